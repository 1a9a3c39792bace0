// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "contact_patch.h"
#include "convex_manifold.h"
#include "surface_memory.h"
#include "tandem/collision/triangle_mesh.h"

namespace tandem::collision {

/// A contact point with one triangle, before points of like normals are put together.
struct MeshPoint {
  RawPoint point;
  Vec3 normal;  ///< unit, from the convex shape to the mesh
  double rank;  ///< m; the gap, with a head start for normals of the last step
  std::uint32_t triangle;
  int cluster;
};

/// Memory kept from call to call.
struct MeshScratch {
  std::vector<MeshPoint> points;
  std::vector<RawPoint> cluster;
};

/// Where a mesh stands in the frame of the query.
struct MeshPose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
};

/// One triangle of a TriangleMesh or a HeightField, in the frame of the query.
template <class Surface>
ConvexCore triangle_core(const Surface& mesh, std::uint32_t t, const MeshPose& pose) {
  ConvexCore core;
  core.kind = CoreKind::Triangle;
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t v = mesh.corners(t)[k];
    core.corners[k] = pose.rotation * mesh.vertex(v) + pose.translation;
    core.corner_ids[k] = v;
    core.edge_ids[k] = mesh.edge_id(t, k);
  }
  core.centre = (core.corners[0] + core.corners[1] + core.corners[2]) / 3.0;
  core.front = pose.rotation * mesh.normal(t);
  core.size = 1e9;  // the convex shape's size decides
  return core;
}

/// Contacts of a convex shape (no sphere: see sphere_surface.h) with a TriangleMesh or a
/// HeightField: one manifold for each cluster of like normals. Only fronts touch. Normals that
/// point out of the Voronoi region of the triangle's feature they touch (internal edges) give way
/// to the triangle's own normal or are dropped.
/// @param list  triangles found before, which hold as long as the shape stays where they are all
/// @param previous  the pair's last patches, normals in the mesh frame: clusters keep their
///   numbers and points by them
/// @return number of library queries
template <class Surface>
std::size_t collide_mesh(const ConvexCore& a, const Surface& mesh, const MeshPose& pose,
                         const Reach& reach, std::span<const PatchTrace> previous,
                         TriangleList& list, MeshScratch& scratch, std::vector<RawManifold>& out);

/// Contacts of a mesh (as a) with the half-space normal . x <= offset.
RawManifold mesh_half_space(const TriangleMesh& mesh, const MeshPose& pose, const Vec3& normal,
                            double offset, double margin, std::span<const PatchTrace> previous,
                            MeshScratch& scratch);

/// Whether a contact whose normal leaves the front of a triangle in direction n (mesh frame) can
/// come from the triangle's foremost feature: false where a neighbour lies nearer.
template <class Surface>
bool normal_allowed(const Surface& mesh, std::uint32_t triangle, const Vec3& n);

}  // namespace tandem::collision
