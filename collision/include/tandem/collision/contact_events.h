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

/// Two colliders that touch, a the lower one. Where one was removed, its id is stale.
struct TANDEM_API ContactPair {
  ColliderId a = {};
  ColliderId b = {};
  pbd::BodyId body_a = {};
  pbd::BodyId body_b = {};

  friend auto operator<=>(const ContactPair&, const ContactPair&) = default;
};

/// Two colliders that ran into each other.
struct TANDEM_API ContactHit {
  ContactPair pair = {};
  pbd::Vec3 point = pbd::Vec3::Zero();    ///< m, world
  pbd::Vec3 normal = pbd::Vec3::UnitZ();  ///< unit, world, from a to b
  double speed = 0.0;                     ///< m/s, > 0: approach along the normal
  double impulse = 0.0;                   ///< N s, of all normals of the pair in the step
};

/// A sensor and what is in it.
struct TANDEM_API SensorPair {
  ColliderId sensor = {};
  ColliderId visitor = {};
  pbd::BodyId sensor_body = {};
  pbd::BodyId visitor_body = {};

  friend auto operator<=>(const SensorPair&, const SensorPair&) = default;
};

struct TANDEM_API ContactEventOptions {
  double hit_speed = 1.0;  ///< m/s, > 0: slower approaches are no hits
  /// m, >= 0: a pair that touched goes on touching while it is this near and the detector still
  /// looks at it, so that what rests or rolls does not flicker.
  double release_gap = 1e-3;

  /// Whether all fields are within their rules; if not, `error` names field, value and rule.
  bool validate(std::string* error = nullptr) const;
};

/// What began, ended and hit in the last step. After each step:
///
///     solver.step(world, dt);
///     events.update(world, scene);
///     for (const ContactHit& hit : events.hits()) play_sound(hit.point, hit.speed);
///
/// A pair touches where a contact carried a load in the step or the surfaces meet. It begins once
/// and ends once; one that bounces within a step begins in this update and ends in the next one.
/// Removed colliders end their pairs.
///
/// Sensors see colliders, not other sensors, that their filters meet, on other bodies, unless both
/// bodies are static; the shapes themselves must share a point (see SceneQuery::overlap), where the
/// bodies are after the step. Something that has passed through a sensor within the step begins
/// and ends in one update: its way is taken as straight, and a jump by set_pose() is no way.
///
/// All arrays are ascending by pair, made without allocation once their size is known, and valid
/// until the next update(). A scene whose events nobody asks for pays nothing.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API ContactEvents {
 public:
  /// @throws std::invalid_argument where the options do not validate
  explicit ContactEvents(const ContactEventOptions& options = {});
  ~ContactEvents();
  ContactEvents(ContactEvents&&) noexcept;
  ContactEvents& operator=(ContactEvents&&) noexcept;

  /// Compare with the last update. The contacts are those of the world's last step where the scene
  /// is its contact source. One object serves one scene.
  void update(const pbd::World& world, const CollisionScene& scene);

  std::span<const ContactPair> begun() const;
  std::span<const ContactPair> ended() const;
  std::span<const ContactHit> hits() const;
  /// All pairs that touch now.
  std::span<const ContactPair> touching() const;
  std::span<const SensorPair> sensor_begun() const;
  std::span<const SensorPair> sensor_ended() const;
  /// All that is in sensors now.
  std::span<const SensorPair> in_sensors() const;

  /// What the next update() compares with, for snapshots: beside World::snapshot().
  void save(pbd::ByteWriter& out) const;
  /// Other bytes leave `in` failed and the events as after construction.
  void load(pbd::ByteReader& in);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::collision
