// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/scenes/scene.h"

namespace tandem::bench {

/// What is not given stays at the engine's default.
struct Settings {
  /// Tandem: substeps of the solver. Bullet: whole steps for each frame. Default of Bullet: 1.
  std::optional<int> substeps;
  /// Tandem: position iterations. Bullet: solver iterations, 10 by default.
  std::optional<int> iterations;
  std::optional<int> velocity_iterations;  ///< Tandem only
  int threads = 1;                         ///< Tandem only
  bool sleeping = false;
  bool recycling = true;  ///< Tandem only: keep the contacts of pairs that hardly moved
};

/// What the engine says of itself; empty where it does not.
struct EngineStats {
  std::vector<std::pair<std::string, double>> stage_s;  ///< of the last step
  int substeps = 0;  ///< of the last step; before the first one, as set
};

/// One scene in one engine. Bodies are numbered as in the scene.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  /// One frame of dt seconds; nothing but the engine's own step may happen in here, it is timed.
  virtual void step(double dt) = 0;
  virtual pbd::BodyState state(int body) const = 0;
  virtual EngineStats stats() const { return {}; }
  virtual void set_twist(int body, const Twist& twist) = 0;
  /// Puts a body somewhere else; its velocity knows nothing of it.
  virtual void set_pose(int body, const Pose& pose) = 0;
  /// Pairs of bodies that pushed each other in the last step, ascending, each once; appended.
  virtual void touching(std::vector<std::pair<int, int>>& out) const = 0;
};

/// @throws std::invalid_argument where the engine cannot build the scene: what() says why
using MakeEngine = std::function<std::unique_ptr<Engine>(const Scene&, const Settings&)>;

std::unique_ptr<Engine> make_tandem(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_bullet(const Scene& scene, const Settings& settings);

}  // namespace tandem::bench
