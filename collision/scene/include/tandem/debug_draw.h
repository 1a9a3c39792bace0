// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem {

/// Meaning of a line; the application picks the colours.
enum class DebugKind : std::uint8_t {
  Static,      ///< shapes of static bodies
  Kinematic,   ///< shapes of kinematic bodies
  Awake,       ///< shapes of awake dynamic bodies
  Asleep,      ///< shapes of sleeping dynamic bodies
  Sensor,      ///< sensors, of any body
  Contact,     ///< 10 cm from a contact point along the normal
  Force,       ///< from a contact point along the force, times force_scale
  Joint,       ///< between the centres of mass of bodies joined by any row
  Correction,  ///< from the pose before agreement moved the body in the last step to the pose now
};

struct TANDEM_API DebugDrawOptions {
  bool shapes = true;
  bool contacts = true;
  bool joints = true;
  bool corrections = true;
  double force_scale = 1e-3;  ///< m/N
};

/// Interface for the application: line() is mandatory.
class TANDEM_API DebugDraw {
 public:
  virtual ~DebugDraw() = default;

  /// m, world.
  virtual void line(const pbd::Vec3& from, const pbd::Vec3& to, DebugKind kind) = 0;
  /// By default draws a wireframe of lines: edges of boxes, hulls, meshes and fields; rings of 24
  /// chords and four lines for round shapes; a square of 20 m for a half-space.
  virtual void shape(const collision::Shape& shape, const pbd::Pose& pose, DebugKind kind);
};

/// Draws a world after a step: shapes at their current poses, contacts with forces, rows that join
/// bodies, and corrections by agreement. Changes nothing; allocates only the list of rows.
/// @param shapes  null: none
TANDEM_API void debug_draw(const pbd::World& world, const collision::CollisionScene* shapes,
                           DebugDraw& out, const DebugDrawOptions& options = {});

}  // namespace tandem
