// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <memory>
#include <span>
#include <string>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// Two touching colliders, a < b. The id of a removed collider is stale.
struct TANDEM_API ContactPair {
  ColliderId a = {};
  ColliderId b = {};
  pbd::BodyId body_a = {};
  pbd::BodyId body_b = {};

  friend auto operator<=>(const ContactPair&, const ContactPair&) = default;
};

/// Two colliders that hit each other.
struct TANDEM_API ContactHit {
  ContactPair pair = {};
  pbd::Vec3 point = pbd::Vec3::Zero();    ///< m, world
  pbd::Vec3 normal = pbd::Vec3::UnitZ();  ///< unit, world, from a to b
  double speed = 0.0;                     ///< m/s, > 0: approach along the normal
  double impulse = 0.0;                   ///< N s, sum over all normals of the pair in the step
};

/// A sensor and a collider inside it.
struct TANDEM_API SensorPair {
  ColliderId sensor = {};
  ColliderId visitor = {};
  pbd::BodyId sensor_body = {};
  pbd::BodyId visitor_body = {};

  friend auto operator<=>(const SensorPair&, const SensorPair&) = default;
};

struct TANDEM_API ContactEventOptions {
  double hit_speed = 1.0;  ///< m/s, > 0: slower approaches are no hits
  /// m, >= 0, hysteresis: a touching pair keeps touching while it is this near and the detector
  /// still reports it, so that resting and rolling bodies do not flicker.
  double release_gap = 1e-3;

  /// Whether all fields are valid; if not, `error` names field, value and rule.
  bool validate(std::string* error = nullptr) const;
};

/// Contacts that began, ended or hit in the last step. After each step:
///
///     solver.step(world, dt);
///     events.update(world, scene);
///     for (const ContactHit& hit : events.hits()) play_sound(hit.point, hit.speed);
///
/// A pair touches if a contact carried a load in the step or the surfaces meet. It begins once and
/// ends once; a pair that bounces within a step begins in this update and ends in the next one.
/// Removing a collider ends its pairs.
///
/// A sensor reports colliders of other bodies that pass its filter, except other sensors and pairs
/// of static bodies. The shapes must share a point (see SceneQuery::overlap) at the poses after the
/// step. A collider that passed through a sensor within the step begins and ends in one update: its
/// path is taken as straight, and set_pose() is not a path.
///
/// All arrays are sorted by pair, made without allocation once their size is known, and valid until
/// the next update(). Scenes without ContactEvents pay nothing.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API ContactEvents {
 public:
  /// @throws std::invalid_argument if the options are not valid
  explicit ContactEvents(const ContactEventOptions& options = {});
  ~ContactEvents();
  ContactEvents(ContactEvents&&) noexcept;
  ContactEvents& operator=(ContactEvents&&) noexcept;

  /// Compares with the last update. Contacts are those of the world's last step, if the scene is
  /// its contact source. One object serves one scene.
  void update(const pbd::World& world, const CollisionScene& scene);

  std::span<const ContactPair> begun() const;
  std::span<const ContactPair> ended() const;
  std::span<const ContactHit> hits() const;
  /// All pairs that touch now.
  std::span<const ContactPair> touching() const;
  std::span<const SensorPair> sensor_begun() const;
  std::span<const SensorPair> sensor_ended() const;
  /// All pairs of a sensor and a collider in it now.
  std::span<const SensorPair> in_sensors() const;

  /// Saves the state that the next update() compares with; complements World::snapshot().
  void save(pbd::ByteWriter& out) const;
  /// Invalid input leaves `in` failed and the events as after construction.
  void load(pbd::ByteReader& in);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::collision
