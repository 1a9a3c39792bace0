// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "broad_phase.h"
#include "collider.h"
#include "core_cast.h"
#include "pair_query.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/workers.h"

namespace tandem::collision {

/// Colliders that one worker takes at a time.
inline constexpr std::size_t kColliderGrain = 128;

/// @throws std::invalid_argument naming field, value and rule
void check_def(const pbd::World& world, const ColliderDef& def);

/// In contact_source.cpp what makes contacts, in motion_limit.cpp what stops bodies on their way,
/// in cache_io.cpp snapshots, in scene_copy.cpp copies.
class __attribute__((visibility("hidden"))) CollisionScene::Impl {
 public:
  explicit Impl(const CollisionOptions& options) : options_(options) {}

  ColliderId add(const pbd::World& world, const ColliderDef& def);
  void remove(ColliderId id);
  void set_material(ColliderId id, const Material& material);
  void set_filter(ColliderId id, const Filter& filter);
  void set_user_data(ColliderId id, std::uint64_t value);
  bool contains(ColliderId id) const {
    return id.index < colliders_.size() && colliders_[id.index].alive &&
           colliders_[id.index].generation == id.generation;
  }
  const Collider& checked(ColliderId id, const char* what) const;
  void collect(const pbd::World& world, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out);
  void limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                    pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits);
  void remove_body(pbd::BodyId body);
  void save(pbd::ByteWriter& out) const;
  bool load(pbd::ByteReader& in);
  void forget();
  void assign(const Impl& source);

  const CollisionOptions& options() const { return options_; }
  const CollisionStats& stats() const { return stats_; }
  const std::vector<Collider>& colliders() const { return colliders_; }
  std::size_t sensor_count() const { return sensor_count_; }

 private:
  /// What one worker needs and finds.
  struct Worker {
    QueryScratch scratch;
    CollisionStats stats;
    std::vector<pbd::Manifold> found;
    std::vector<pbd::MotionLimit> limits;
    std::vector<std::uint32_t> stack;
    std::vector<std::uint32_t> list;
  };
  /// Where the manifolds of a chunk of pairs are.
  struct Chunk {
    int worker = 0;
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  double fastest_obstacle(std::span<const pbd::Pose> after) const;
  CoreHit first_hit(Collider& collider, bool bullet, double fastest,
                    std::span<const pbd::Pose> after, Worker& worker) const;
  void guard(std::uint32_t index, std::uint32_t near);
  void update_order(const pbd::World& world);
  void assign_caches(const std::vector<PairCache>& source);
  void collect_pair(ColliderPair& entry, double dt, Worker& worker,
                    std::vector<pbd::Manifold>& out);
  void collect_pairs(std::size_t begin, std::size_t end, double dt, Worker& worker,
                     std::vector<pbd::Manifold>& out);
  void collect_all_pairs(double dt, pbd::Workers& workers, std::vector<pbd::Manifold>& out);
  void sum_stats(std::span<const pbd::Manifold> found);

  CollisionOptions options_;
  CollisionStats stats_;
  std::vector<Collider> colliders_;
  std::vector<std::uint32_t> free_;
  std::size_t sensor_count_ = 0;
  std::uint64_t added_ = 0;
  bool order_is_old_ = true;
  bool natural_order_ = true;
  /// What is known was loaded, in the order of the world that comes with it.
  bool restored_ = false;
  std::uint64_t sleepers_moved_ = 0;  ///< see World::sleepers_moved()
  BroadPhase broad_;
  PatchPool pool_;
  std::vector<PairCache> caches_;  ///< by slot
  std::vector<Worker> workers_;
  std::vector<Chunk> chunks_;
};

}  // namespace tandem::collision
