// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "gltf_meshes.h"

namespace tandem::scene_files {

inline constexpr const char* kGltfPhysics = "KHR_physics_rigid_bodies";

/// Round-off of single precision: of 0, and relative for equal numbers.
inline constexpr double kGltfRoundOff = 1e-6;

/// Where a node is.
struct GltfFrame {
  Pose pose;
  Vec3 scale = Vec3::Ones();
  bool sheared = false;  ///< turned below an uneven scale: pose and scale are not all of it
};

/// A rotation about x. @param angle  rad
Quat gltf_about_x(double angle);

/// Colliders and triggers of glTF nodes, with their materials and filters.
class GltfColliders {
 public:
  GltfColliders(const Place& document, const GltfSources& sources)
      : document_(document), meshes_(document, sources) {}

  /// Appends the collider, placed in the body's frame; nothing, with a warning, if its kind is
  /// unknown.
  void add(const Place& at, const GltfFrame& frame, bool sensor, const Pose& body,
           std::vector<collision::ColliderDef>& out);

 private:
  /// @return false, after a warning, if there is no such shape
  bool shape(const Place& geometry, const Vec3& scale, collision::ColliderDef& def);
  bool implicit(const Place& index, const Vec3& signed_scale, collision::ColliderDef& def);
  void material(const Place& index, collision::Material& out);
  void filter(const Place& index, collision::Filter& out);

  const Place& document_;
  GltfMeshes meshes_;
  std::map<std::string, std::uint32_t> systems_;
  std::map<std::int64_t, collision::Material> materials_;
  std::map<std::int64_t, collision::Filter> filters_;
};

}  // namespace tandem::scene_files
