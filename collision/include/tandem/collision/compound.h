// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"

namespace tandem::collision {

/// One part of a body made of several shapes.
struct TANDEM_API CompoundPart {
  Shape shape = {};
  pbd::Pose local = {};  ///< pose of the shape in the compound's frame
  double density = 1e3;  ///< kg/m^3, > 0; read by mass_properties() only
};

/// Mass properties of all parts together, in the compound's frame; overlapping parts count twice.
/// @throws std::invalid_argument  as for a single shape, naming the part; if there is no part; or
///   if the mass, centre or inertia of all parts together is not finite
TANDEM_API MassProperties mass_properties(std::span<const CompoundPart> parts);

/// Adds the parts to a body as colliders that share everything but shape and pose.
/// @param def  the shared fields: body, material, filters; def.local places the compound's frame in
///   the body's, def.shape is not read
/// @return one id per part, in their order
/// @throws std::invalid_argument  as CollisionScene::add(); nothing is added then
TANDEM_API std::vector<ColliderId> add_compound(CollisionScene& scene, const pbd::World& world,
                                                const ColliderDef& def,
                                                std::span<const CompoundPart> parts);

}  // namespace tandem::collision
