// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "message.h"
#include "tandem/collision/contact_source.h"

namespace tandem::mpi {

/// Hulls registered on all ranks in the same order, sent as their ordinal.
using Hulls = std::vector<collision::Hull>;

/// Whether a collider's shape can be sent: a few numbers describe it.
bool can_move(const collision::Shape& shape, const Hulls& hulls);
bool is_surface(const collision::Shape& shape);  ///< a mesh or a height field
/// m: largest distance of the shape's points from the body's centre of mass.
double reach_of(const collision::ColliderDef& collider);
void write_collider(const collision::ColliderDef& collider, const Hulls& hulls, MessageWriter& out);
/// @return false if the bytes are no collider's
bool read_collider(MessageReader& in, const Hulls& hulls, collision::ColliderDef& collider);

}  // namespace tandem::mpi
