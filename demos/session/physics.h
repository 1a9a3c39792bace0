// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/scene.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos {

enum class Engine : std::uint8_t {
  Tandem,
  /// An impulse engine, by the paper's two steps. The world mirrors it.
  Bullet,
};
std::string_view to_string(Engine engine);

/// Moves a peer's bodies between before_step and after_step.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Physics {
 public:
  virtual ~Physics() = default;
  /// One step of `dt` s of the scene's world. @param peer  of that world
  virtual const pbd::StepReport& step(Scene& scene, consensus::Peer& peer, double dt) = 0;
  /// Pairs of the scene's shared bodies, by index, in contact in the last step; null: ask the
  /// world.
  virtual const std::vector<std::pair<std::size_t, std::size_t>>* touching() const {
    return nullptr;
  }
};

/// @param iterations  of the other engine's solver; nullopt = its default
/// @param solver      of Tandem's
/// @throws std::invalid_argument if the engine is not in this build, or does not support the scene
std::unique_ptr<Physics> make_physics(Engine engine, const Scene& scene,
                                      std::optional<int> iterations = std::nullopt,
                                      const pbd::SolverOptions& solver = {});

/// True if Bullet is in this build.
bool has_bullet();

std::unique_ptr<Physics> make_bullet_physics(const Scene& scene, std::optional<int> iterations);

}  // namespace tandem::demos
