// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "demos/engine/engine.h"
#include "measure/penetration.h"

namespace tandem::bench {

/// Name and value, in the order of a report.
using Measures = std::vector<std::pair<std::string, double>>;

/// Kinetic energy (J) of the scene's moving bodies.
double kinetic_energy(const Scene& scene, const Engine& engine);
/// Kinetic and gravitational energy (J), zero height at the origin. Heights are taken half a
/// substep back, which is when the velocity of x += h v is that of the motion: a free fall then
/// keeps its energy to the last digit, and what changes in other scenes is the engine's doing.
double mechanical_energy(const Scene& scene, const Engine& engine);
/// Distance (m) between the two anchors of each ball joint and hinge.
std::vector<double> joint_separations(const Scene& scene, const Engine& engine);
/// The largest of them, 0 where there is none.
double joint_separation(const Scene& scene, const Engine& engine);

/// What a scene's run is judged by, watched frame by frame and told at the end. Lengths in m,
/// energies in J; "_end" at the last frame, "_max" over all frames, unless said.
class Quality {
 public:
  /// @param reference  where the chain's ball is in each frame (m), may be empty
  Quality(const Scene& scene, const Engine& engine, std::vector<Vec3> reference);
  ~Quality();
  Quality(const Quality&) = delete;
  Quality& operator=(const Quality&) = delete;

  /// @param frame  counts from 0
  void after_frame(int frame, const Engine& engine);
  Measures finish(const Engine& engine);

 private:
  class Watch;
  class StackWatch;
  class PyramidWatch;
  class RatioWatch;
  class ChainWatch;
  class CliffWatch;
  class HeapWatch;
  class JointWatch;

  const Scene& scene_;
  std::unique_ptr<PenetrationProbe> probe_;
  std::unique_ptr<Watch> watch_;
  double deepest_ = 0.0;
  double max_kinetic_last_second_ = 0.0;
};

/// Lines "t x y z" -> positions. @throws std::runtime_error where the file cannot be read
std::vector<Vec3> read_reference(const std::string& path);

}  // namespace tandem::bench
