// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "convex_manifold.h"

namespace tandem::collision {

/// Appends points on the axis' face as the reference.
void face_contact(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                  const Reach& reach, RawManifold& out);

/// Replaces a contact between edges by one on a face, see kAlongside. Returns whether it does.
/// Boxes only: beside a face of another hull there may still be parts of that hull.
bool serve_by_face(const ConvexCore& a, const ConvexCore& b, const ContactAxis& edges,
                   const Reach& reach, RawManifold& out);

}  // namespace tandem::collision
