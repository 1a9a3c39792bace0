// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "place.h"

namespace tandem::scene_files {

/// Two nodes with a joint between them.
struct Joined {
  std::optional<std::size_t> a, b;  ///< indices of bodies; none: the world
  Pose frame_a, frame_b;            ///< world
  std::size_t description = 0;      ///< index in physicsJoints
  bool meet = false;                ///< the bodies meet each other
  std::string name;
};

/// Joints of a glTF document.
class GltfJoints {
 public:
  GltfJoints(const Place& document, SceneFile& out) : document_(document), out_(out) {}

  void add(Joined joined) { joined_.push_back(std::move(joined)); }
  /// By body: jointed bodies share a group and do not meet each other; 0: no joint.
  std::vector<std::int32_t> groups(std::size_t bodies);
  /// Call when out.bodies is complete.
  void build();

 private:
  /// Read on demand: many nodes may name one.
  pbd::SixDofJointDef describe(std::size_t description);

  const Place& document_;
  SceneFile& out_;
  std::vector<Joined> joined_;
  std::map<std::size_t, pbd::SixDofJointDef> known_;
};

}  // namespace tandem::scene_files
