// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "surface_memory.h"

namespace tandem::collision {

/// A contact of a sphere with a triangle surface.
struct SphereTouch {
  Vec3 normal;                ///< unit, from the sphere to the surface, mesh frame
  double distance = 0.0;      ///< m, of the centre along the normal
  Vec3 point = Vec3::Zero();  ///< m, mesh frame, on the surface
  double rank = 0.0;          ///< m; the distance, with a bonus for normals of the last step
  std::uint32_t triangle = 0;
  std::uint32_t cluster = 0;
  bool beside = false;  ///< not across the front: the Voronoi region of the feature must be tested
};

/// Scratch memory, kept from call to call.
struct SphereScratch {
  std::vector<SphereTouch> near;
  std::vector<SphereTouch> touches;
};

/// Writes the contacts of a sphere with a TriangleMesh or a HeightField to scratch.touches,
/// ascending by cluster. A sphere touches a triangle at its point nearest to the centre, if that is
/// in the triangle's own region. A closed form: the library keeps the last edge in reach instead of
/// the nearest (see fcl_bridge.cpp).
/// @param centre  m, mesh frame     @param margin  m, largest gap
/// @param sweep   m, mesh frame, motion of the surface relative to the sphere within the step
/// @param previous  the pair's last patches, normals in the mesh frame
/// @param list  triangles found before, valid while the sphere stays near
template <class Surface>
void touch_surface(const Vec3& centre, double radius, double margin, const Vec3& sweep,
                   const Surface& surface, std::span<const PatchTrace> previous, TriangleList& list,
                   SphereScratch& scratch);

}  // namespace tandem::collision
