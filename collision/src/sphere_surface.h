// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "surface_memory.h"

namespace tandem::collision {

/// Where a sphere touches a surface of triangles.
struct SphereTouch {
  Vec3 normal;                ///< unit, from the sphere to the surface, mesh frame
  double distance = 0.0;      ///< m, of the centre along the normal
  Vec3 point = Vec3::Zero();  ///< m, mesh frame, on the surface
  double rank = 0.0;          ///< m; the distance, with a head start for normals of the last step
  std::uint32_t triangle = 0;
  std::uint32_t cluster = 0;
  bool beside = false;  ///< not across the front: the region of the feature has to be looked at
};

/// Memory kept from call to call.
struct SphereScratch {
  std::vector<SphereTouch> near;
  std::vector<SphereTouch> touches;
};

/// Contacts of a sphere with a TriangleMesh or a HeightField into scratch.touches, ascending by
/// cluster. A sphere touches a triangle at its point nearest to the centre, if that lies in the
/// triangle's own region. A closed form: the library keeps the last edge in reach in place of the
/// nearest one (see fcl_bridge.cpp).
/// @param centre  m, mesh frame     @param margin  m, largest gap
/// @param sweep   m, mesh frame, motion of the surface against the sphere within the step
/// @param previous  the pair's last patches, normals in the mesh frame
/// @param list  triangles found before, which hold as long as the sphere stays near
template <class Surface>
void touch_surface(const Vec3& centre, double radius, double margin, const Vec3& sweep,
                   const Surface& surface, std::span<const PatchTrace> previous, TriangleList& list,
                   SphereScratch& scratch);

}  // namespace tandem::collision
