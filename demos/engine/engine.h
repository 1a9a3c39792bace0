// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "demos/engine/scene.h"

namespace tandem::bench {

/// What is not given stays at the engine's default.
struct Settings {
  /// Tandem, Box3D: substeps of the solver. Jolt: collision steps. Others: whole steps for each
  /// frame.
  std::optional<int> substeps;
  /// Position iterations; of Bullet solver iterations, of Jolt velocity steps, of Box3D nothing.
  std::optional<int> iterations;
  std::optional<int> velocity_iterations;  ///< Tandem only
  int threads = 1;                         ///< Tandem only
  bool sleeping = false;
  bool recycling = true;  ///< Tandem only: keep the contacts of pairs that hardly moved
};

/// What the engine says of itself; empty where it does not.
struct EngineStats {
  std::vector<std::pair<std::string, double>> stage_s;  ///< of the last step
  int substeps = 0;     ///< of the last step; before the first one, as set
  bool failed = false;  ///< it says so of the last step
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
  /// Where Settings::sleeping let it fall asleep: whether it has not.
  virtual bool awake(int body) const = 0;
  virtual void set_twist(int body, const Twist& twist) = 0;
  /// Puts a body somewhere else; its velocity knows nothing of it.
  virtual void set_pose(int body, const Pose& pose) = 0;
  /// Pairs of bodies that pushed each other in the last step, ascending, each once; appended.
  /// @throws std::logic_error where the adapter does not tell
  virtual void touching(std::vector<std::pair<int, int>>& /*out*/) const {
    throw std::logic_error(name() + ": its adapter does not tell what touches");
  }
};

/// @throws std::invalid_argument where the engine cannot build the scene: what() says why
using MakeEngine = std::function<std::unique_ptr<Engine>(const Scene&, const Settings&)>;

std::unique_ptr<Engine> make_tandem(const Scene& scene, const Settings& settings);
// Those that the build has: benchmarks/peers.
std::unique_ptr<Engine> make_bullet(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_jolt(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_box3d(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_physx_pgs(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_physx_tgs(const Scene& scene, const Settings& settings);

}  // namespace tandem::bench
