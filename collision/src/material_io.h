// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/collision/material.h"
#include "tandem/pbd/bytes.h"

namespace tandem::collision {

/// What may change after a collider was made, for snapshots.
void save_surface(pbd::ByteWriter& out, const Material& material, const Filter& filter);
/// @return false where the bytes are no material
bool load_surface(pbd::ByteReader& in, Material& material, Filter& filter);

}  // namespace tandem::collision
