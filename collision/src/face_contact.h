// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "convex_manifold.h"

namespace tandem::collision {

/// Points on the axis' face as the reference, appended.
void face_contact(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                  const Reach& reach, RawManifold& out);

/// Contact on a face in place of one between edges, see kAlongside. Whether it serves. Boxes only:
/// what lies beside the face of another hull may still be in that hull.
bool serve_by_face(const ConvexCore& a, const ConvexCore& b, const ContactAxis& edges,
                   const Reach& reach, RawManifold& out);

}  // namespace tandem::collision
