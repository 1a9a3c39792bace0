// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "query_colliders.h"
#include "tandem/collision/contact_events.h"
#include "tandem/pbd/bytes.h"

namespace tandem::collision {

/// Finds the colliders that are in sensors, and those that passed through since the last update.
class Sensors {
 public:
  /// @param[out] inside   ascending
  /// @param[out] passed   ascending: neither inside now nor, as far as known here, before
  void find(const pbd::World& world, const CollisionScene& scene, std::vector<SensorPair>& inside,
            std::vector<SensorPair>& passed);

  void save(pbd::ByteWriter& out) const;
  bool load(pbd::ByteReader& in);
  void forget();

 private:
  /// State of a collider at the last update.
  struct Last {
    bool known = false;
    std::uint32_t generation = 0;
    pbd::Vec3 position = pbd::Vec3::Zero();  ///< m
    double speed = 0.0;                      ///< m/s
  };

  bool sees(std::uint32_t sensor, std::uint32_t visitor) const;
  pbd::Vec3 way_of(std::uint32_t index, double dt) const;
  bool passes(std::uint32_t sensor, std::uint32_t visitor) const;
  SensorPair pair_of(std::uint32_t sensor, std::uint32_t visitor) const;
  void remember(const pbd::World& world);

  QueryColliders colliders_;
  std::vector<Last> last_;
  std::vector<pbd::Vec3> way_;         ///< m, by slot: straight path since the last update
  std::vector<std::uint32_t> moving_;  ///< slots of colliders that may have passed through
  double time_ = 0.0;                  ///< s, of the world at the last update
};

}  // namespace tandem::collision
