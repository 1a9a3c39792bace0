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

/// A contact point with one triangle, before points of similar normals are merged.
struct MeshPoint {
  RawPoint point;
  Vec3 normal;  ///< unit, from the convex shape to the mesh
  double rank;  ///< m; the gap, with a bonus for normals of the last step
  std::uint32_t triangle;
  int cluster;
};

/// Scratch memory, kept from call to call.
struct MeshScratch {
  std::vector<MeshPoint> points;
  std::vector<RawPoint> cluster;
};

/// Pose of a mesh in the frame of the query.
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
  core.size = 1e9;  // "no bound": the convex shape's size decides
  return core;
}

/// Contacts of a convex shape (no sphere: see sphere_surface.h) with a TriangleMesh or a
/// HeightField: one manifold per cluster of similar normals. Only fronts touch. A normal outside
/// the Voronoi region of the feature that it touches (internal edges) is replaced by the triangle's
/// own normal, or the point is dropped.
/// @param list  triangles found before, valid while the shape stays within the list's box
/// @param previous  the pair's last patches, normals in the mesh frame: clusters keep their numbers
///   and points by them
/// @return number of library queries
template <class Surface>
std::size_t collide_mesh(const ConvexCore& a, const Surface& mesh, const MeshPose& pose,
                         const Reach& reach, std::span<const PatchTrace> previous,
                         TriangleList& list, MeshScratch& scratch, std::vector<RawManifold>& out);

/// Contacts of a mesh a with the half-space normal . x <= offset.
RawManifold mesh_half_space(const TriangleMesh& mesh, const MeshPose& pose, const Vec3& normal,
                            double offset, double margin, std::span<const PatchTrace> previous,
                            MeshScratch& scratch);

/// Whether a contact whose normal leaves the front of a triangle in direction n (mesh frame) can
/// belong to the triangle's foremost feature: false if a neighbour is nearer.
template <class Surface>
bool normal_allowed(const Surface& mesh, std::uint32_t triangle, const Vec3& n);

}  // namespace tandem::collision
