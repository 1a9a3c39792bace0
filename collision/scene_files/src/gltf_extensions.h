// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "place.h"

namespace tandem::scene_files {

/// Refuses a document that requires an extension which is not read, as glTF has it, and warns of
/// physics that it uses and nobody reads.
void check_gltf_extensions(const Place& document);

/// A document by OMI_physics_body and OMI_physics_shape as one by KHR_physics_rigid_bodies and
/// KHR_implicit_shapes, which have the same parts by other names. One that has the latter is left
/// as it is. What is not as OMI says is carried over for the reader to refuse, by its new name.
void rewrite_omi_physics(json& document);

}  // namespace tandem::scene_files
