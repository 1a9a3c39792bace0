// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "message.h"
#include "tandem/collision/contact_source.h"

namespace tandem::mpi {

/// Whether a collider's shape can go from rank to rank: it is all in its few numbers.
bool can_move(const collision::Shape& shape);
bool is_surface(const collision::Shape& shape);  ///< a mesh or a height field
/// m: of the shape's points, the one furthest from the body's centre of mass.
double reach_of(const collision::ColliderDef& collider);
void write_collider(const collision::ColliderDef& collider, MessageWriter& out);
/// @return false where the bytes are no collider's
bool read_collider(MessageReader& in, collision::ColliderDef& collider);

}  // namespace tandem::mpi
