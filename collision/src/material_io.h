// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/collision/material.h"
#include "tandem/pbd/bytes.h"

namespace tandem::collision {

/// Fields that may change after a collider was made, for snapshots.
void save_surface(pbd::ByteWriter& out, const Material& material, const Filter& filter);
/// @return false if the input is no valid material
bool load_surface(pbd::ByteReader& in, Material& material, Filter& filter);

}  // namespace tandem::collision
