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

/// J, of moving bodies.
double kinetic_energy(const Scene& scene, const Engine& engine);
/// Kinetic and gravitational energy (J), zero height at the origin. Heights are taken half a
/// substep earlier, the time of the velocities in x += h v, so that a free fall conserves energy
/// exactly.
double mechanical_energy(const Scene& scene, const Engine& engine);
/// Distance (m) between the two anchors of each ball joint and hinge.
std::vector<double> joint_separations(const Scene& scene, const Engine& engine);
/// The largest of them, 0 if there is none.
double joint_separation(const Scene& scene, const Engine& engine);

/// Measures of a scene's run, collected frame by frame. Lengths in m, energies in J; "_end" at the
/// last frame, "_max" over all, by default.
class Quality {
 public:
  /// @param reference  positions of the chain's ball per frame (m), may be empty
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

/// Lines "t x y z" -> positions. @throws std::runtime_error if the file cannot be read
std::vector<Vec3> read_reference(const std::string& path);

}  // namespace tandem::bench
