// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "place.h"

namespace tandem::scene_files {

/// Refuses a document that requires an unknown extension, as glTF demands, and warns of physics
/// extensions that it uses and that are not read.
void check_gltf_extensions(const Place& document);

/// Converts OMI_physics_body and OMI_physics_shape to KHR_physics_rigid_bodies and
/// KHR_implicit_shapes, which have the same parts under other names. A document that has the latter
/// is left as it is. Invalid OMI values are carried over, for the reader to refuse by their new
/// names.
void rewrite_omi_physics(json& document);

}  // namespace tandem::scene_files
