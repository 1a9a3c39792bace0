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

/// Unset values keep the engine's default.
struct Settings {
  /// Tandem, Box3D: substeps of the solver. Jolt: collision steps. Others: whole steps per frame.
  std::optional<int> substeps;
  /// Position iterations; Bullet: solver iterations; Jolt: velocity steps; Box3D: unused.
  std::optional<int> iterations;
  std::optional<int> velocity_iterations;  ///< Tandem only
  int threads = 1;                         ///< Tandem only
  bool sleeping = false;
  bool recycling = true;  ///< Tandem only: keep the contacts of pairs that hardly moved
};

/// Statistics of the engine itself; empty if it has none.
struct EngineStats {
  std::vector<std::pair<std::string, double>> stage_s;  ///< of the last step
  int substeps = 0;     ///< of the last step; before the first one, the setting
  bool failed = false;  ///< the engine reports that the last step failed
};

/// One scene in one engine. Bodies are numbered as in the scene.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  /// One frame of dt seconds. It is timed: nothing but the engine's own step belongs here.
  virtual void step(double dt) = 0;
  virtual pbd::BodyState state(int body) const = 0;
  virtual EngineStats stats() const { return {}; }
  /// False once asleep, if Settings::sleeping allows sleep.
  virtual bool awake(int body) const = 0;
  virtual void set_twist(int body, const Twist& twist) = 0;
  /// Moves a body without changing its velocity.
  virtual void set_pose(int body, const Pose& pose) = 0;
  /// Appends the pairs of bodies in contact in the last step, ascending, each once.
  /// @throws std::logic_error if the adapter has no such report
  virtual void touching(std::vector<std::pair<int, int>>& /*out*/) const {
    throw std::logic_error(name() + ": its adapter does not tell what touches");
  }
};

/// @throws std::invalid_argument if the engine cannot build the scene: what() says why
using MakeEngine = std::function<std::unique_ptr<Engine>(const Scene&, const Settings&)>;

std::unique_ptr<Engine> make_tandem(const Scene& scene, const Settings& settings);
// Which of these a build has depends on its libraries: benchmarks/peers.
std::unique_ptr<Engine> make_bullet(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_jolt(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_box3d(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_physx_pgs(const Scene& scene, const Settings& settings);
std::unique_ptr<Engine> make_physx_tgs(const Scene& scene, const Settings& settings);

}  // namespace tandem::bench
