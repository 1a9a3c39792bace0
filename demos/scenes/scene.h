// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/consensus/shared_id.h"
#include "tandem/pbd/world.h"

namespace tandem::demos {

/// Differences between one peer's copy of a scene and another's.
struct SceneOptions {
  std::uint64_t order_seed = 0;  ///< shuffles the order in which bodies are added; 0 = as listed
  std::uint64_t noise_seed = 0;  ///< seed of the start-up noise; 0 = none
  double noise = 1e-4;           ///< m, each coordinate of a shared body starts within +- this
  std::uint64_t users = ~std::uint64_t{0};  ///< bit u: user u is at this peer
};

struct ScenePart {
  collision::Shape shape;
  pbd::Pose local;  ///< in the frame of the body
};

struct SceneBody {
  std::string name;
  consensus::SharedId id;                      ///< of the name
  pbd::BodyId body;                            ///< in this peer's world
  std::vector<ScenePart> parts;                ///< about the centre of mass
  pbd::Vec3 half_extents = pbd::Vec3::Zero();  ///< m, of the bounding box of the parts
  pbd::Vec3 start = pbd::Vec3::Zero();         ///< m, world, without noise
  bool collides = true;
  /// The user whose hand moves it, alone. It is kinematic there and follows elsewhere.
  std::optional<std::size_t> owner;
};

/// A static shape that is not shared.
struct FixedPart {
  collision::Shape shape;
  pbd::Pose pose;  ///< world
};

/// One peer's copy of a scene.
struct Scene {
  std::unique_ptr<pbd::World> world;
  std::unique_ptr<collision::CollisionScene> contacts;  ///< the world's contact source
  std::vector<SceneBody> bodies;  ///< in the same order at all peers, whatever the worlds' order
  std::vector<FixedPart> fixed;   ///< in the same order at all peers

  /// @throws std::invalid_argument if no body has that name
  const SceneBody& body(std::string_view name) const { return bodies[index_of(name)]; }
  std::size_t index_of(std::string_view name) const;
  const pbd::Pose& pose(const SceneBody& body) const { return world->pose(body.body); }
  const pbd::Pose& pose(std::size_t body) const { return world->pose(bodies[body].body); }
  const pbd::Twist& twist(std::size_t body) const { return world->twist(bodies[body].body); }
  double mass(std::size_t body) const { return world->props(bodies[body].body).mass; }
};

/// Finds a scene's shared bodies by their slots in its world.
class BodiesBySlot {
 public:
  BodiesBySlot() = default;
  explicit BodiesBySlot(const Scene& scene) : BodiesBySlot(*scene.world, scene.bodies) {}
  BodiesBySlot(const pbd::World& world, std::span<const SceneBody> bodies);
  /// Its index into Scene::bodies; BodyId::kNone if it is not shared.
  std::uint32_t index_of(const pbd::BodyId& body) const {
    return body.index < indices_.size() ? indices_[body.index] : pbd::BodyId::kNone;
  }

 private:
  std::vector<std::uint32_t> indices_;
};

/// A hash that peers compare before they play together: names and sizes of the shared bodies.
std::uint64_t scene_hash(const Scene& scene);

struct BodySpec {
  std::string name;
  std::vector<ScenePart> parts;  ///< in a frame with any origin
  double mass = 1.0;             ///< kg, of a homogeneous body
  pbd::Pose pose;                ///< of the parts' frame, world
  collision::Material material;
  collision::Filter filter;
  bool collides = true;  ///< false: visible without contacts
  bool bullet = false;
  double linear_damping = 0.0;       ///< 1/s
  double angular_damping = 0.0;      ///< 1/s
  bool held_up = false;              ///< is held in the air until let_fall()
  std::optional<std::size_t> owner;  ///< see SceneBody
};

/// One shape at the origin of the parts' frame.
inline std::vector<ScenePart> one_part(const collision::Shape& shape) {
  std::vector<ScenePart> parts(1);
  parts.front().shape = shape;
  return parts;
}

/// Unrotated. @param x, y, z  m, world
inline pbd::Pose upright_at(double x, double y, double z) {
  return {pbd::Vec3(x, y, z), pbd::Quat::Identity()};
}

/// Drops a held body, effective `age` (s) ago: it moves to where it would be by now.
void let_fall(Scene& scene, std::size_t body, double age);

/// Fills a scene with bodies, in shuffled order.
class SceneBuilder {
 public:
  void add(BodySpec spec) { bodies_.push_back(std::move(spec)); }
  /// A box. @param size  full edge lengths, m     @param mass  kg     @param centre  m, world
  void box(std::string name, const pbd::Vec3& size, double mass, const pbd::Vec3& centre);
  void fix(collision::Shape shape, const pbd::Pose& pose, const collision::Material& material = {});
  /// The half-space normal . x <= offset. @param normal  unit     @param offset  m
  void half_space(const pbd::Vec3& normal, double offset, const collision::Material& material = {});
  /// The half-space z <= 0.
  void ground(const collision::Material& material) {
    half_space(pbd::Vec3::UnitZ(), 0.0, material);
  }

  /// @throws std::invalid_argument if a part, a mass or a name is not valid
  Scene build(const SceneOptions& options) const;
  /// Adds a ground first. @param friction  of the ground and of all box() bodies
  Scene build(const SceneOptions& options, double friction) const;

 private:
  struct Fixed {
    FixedPart part;
    collision::Material material;
  };
  std::vector<BodySpec> bodies_;
  std::vector<Fixed> fixed_;
};

}  // namespace tandem::demos
