// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <span>

#include "demos/engine/engine.h"
#include "tandem/scene.h"

namespace tandem::everyday {

struct WorldOptions {
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s^2
  bool sleeping = true;                  ///< bodies fall asleep by the engine's own rule
};

/// A world of Tandem or of another engine at its defaults. All bodies are added before the first
/// step.
class AnyWorld {
 public:
  virtual ~AnyWorld() = default;

  /// See Scene::add.
  /// @throws std::invalid_argument if the engine or its adapter lacks such a body
  virtual BodyId add(std::span<const collision::CompoundPart> parts, const SolidDef& def) = 0;
  BodyId add(const collision::Shape& shape, const SolidDef& def = {});
  /// Hinge to the world by an axis (unit) through a point (m).
  virtual void add_hinge(BodyId body, const Vec3& point_w, const Vec3& axis_w) = 0;
  /// @throws std::invalid_argument as add()
  virtual void step(double dt) = 0;

  virtual Pose pose(BodyId body) const = 0;  ///< of the shape, as Scene::pose
  virtual pbd::Twist twist(BodyId body) const = 0;
  virtual bool awake(BodyId body) const = 0;
  virtual double kinetic_energy() const = 0;     ///< J
  virtual double mechanical_energy() const = 0;  ///< J, zero height at the origin
};

/// @param peer  makes the other engine; empty: Tandem
std::unique_ptr<AnyWorld> make_world(const bench::MakeEngine& peer,
                                     const WorldOptions& options = {});
std::unique_ptr<AnyWorld> make_peer_world(const bench::MakeEngine& peer,
                                          const WorldOptions& options);

}  // namespace tandem::everyday
