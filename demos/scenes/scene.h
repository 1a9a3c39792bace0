// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/consensus/shared_id.h"
#include "tandem/pbd/world.h"

namespace tandem::demos {

/// How one peer's copy of a scene differs from another's.
struct SceneOptions {
  std::uint64_t order_seed = 0;  ///< shuffles the order in which bodies are added; 0 = as listed
  std::uint64_t noise_seed = 0;  ///< draws the start-up noise; 0 = none
  double noise = 1e-4;           ///< m, each coordinate of a shared body starts within +- this
};

/// A shared box of a scene.
struct SceneBody {
  std::string name;
  consensus::SharedId id;                      ///< of the name
  pbd::BodyId body;                            ///< in this peer's world
  pbd::Vec3 half_extents = pbd::Vec3::Zero();  ///< m
  pbd::Vec3 start = pbd::Vec3::Zero();         ///< m, world, without noise
};

/// One peer's copy of a scene. The ground is the half-space z <= 0.
struct Scene {
  std::unique_ptr<pbd::World> world;
  std::unique_ptr<collision::CollisionScene> contacts;  ///< the world's contact source
  std::vector<SceneBody> bodies;  ///< in the same order at all peers, whatever the worlds' order

  /// @throws std::invalid_argument where there is no body of that name
  const SceneBody& body(std::string_view name) const;
  const pbd::Pose& pose(const SceneBody& body) const { return world->pose(body.body); }
};

/// A hash that peers compare before they play together: names and sizes of the shared bodies.
std::uint64_t scene_hash(const Scene& scene);

/// Fills a scene with boxes, in an order of its own.
class SceneBuilder {
 public:
  /// @param size  full edge lengths, m     @param centre  m, world     @param mass  kg
  void box(std::string name, const pbd::Vec3& size, double mass, const pbd::Vec3& centre);
  /// @param friction  of all bodies and the ground
  Scene build(const SceneOptions& options, double friction) const;

 private:
  struct Box {
    std::string name;
    pbd::Vec3 half_extents;
    double mass;
    pbd::Vec3 centre;
  };
  std::vector<Box> boxes_;
};

}  // namespace tandem::demos
