// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem {

/// What a line stands for: who draws picks the colours.
enum class DebugKind : std::uint8_t {
  Static,      ///< shapes of static bodies
  Kinematic,   ///< likewise
  Awake,       ///< of dynamic ones
  Asleep,      ///< likewise
  Sensor,      ///< sensors, of any body
  Contact,     ///< from a point of contact along the normal, 10 cm
  Force,       ///< from there along the force, by force_scale
  Joint,       ///< between the centres of mass of bodies that a row of any kind joins
  Correction,  ///< where agreement moved a body in the last step, from before to now
};

struct TANDEM_API DebugDrawOptions {
  bool shapes = true;
  bool contacts = true;
  bool joints = true;
  bool corrections = true;
  double force_scale = 1e-3;  ///< m/N
};

/// What the application implements: lines at least.
class TANDEM_API DebugDraw {
 public:
  virtual ~DebugDraw() = default;

  /// m, world.
  virtual void line(const pbd::Vec3& from, const pbd::Vec3& to, DebugKind kind) = 0;
  /// By default its wireframe, of lines: the edges of boxes, hulls, meshes and fields, rings of 24
  /// chords and four lines along what is round, a square of 20 m of a half-space.
  virtual void shape(const collision::Shape& shape, const pbd::Pose& pose, DebugKind kind);
};

/// Show a world as it is after a step: shapes where they are now, contacts with their forces, rows
/// that join bodies, and what agreement did. Changes nothing; allocates for the list of rows alone.
/// @param shapes  null: none
TANDEM_API void debug_draw(const pbd::World& world, const collision::CollisionScene* shapes,
                           DebugDraw& out, const DebugDrawOptions& options = {});

}  // namespace tandem
