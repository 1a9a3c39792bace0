// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

class ByteReader;
class ByteWriter;
class Workers;
class World;

/// One point of a manifold. The anchors are fixed in the two bodies; the gap along the manifold's
/// normal is measured between them, less the manifold's two radii.
struct TANDEM_API ManifoldPoint {
  Vec3 anchor_a_l = Vec3::Zero();  ///< m, frame of body a
  Vec3 anchor_b_l = Vec3::Zero();  ///< m, frame of body b
  std::uint32_t feature = 0;       ///< same value = same pair of features as in the last step
};

/// Contact of one pair of convex parts: what a detector hands to the solver, once per step.
/// gap_i = normal . (p_b,i - p_a,i) - radius_a - radius_b  [m], negative where they overlap.
/// A round part (sphere, capsule) gives its centre or axis point as anchor and its radius here, so
/// that the gap does not change when it rolls.
struct TANDEM_API Manifold {
  static constexpr int kMaxPoints = 4;

  /// Names the pair, the same in every step.
  std::uint64_t key = 0;
  /// Manifolds are solved in ascending order of this, equal ones by key. It may change from step to
  /// step as long as no two manifolds change places; a source that follows World::order() makes
  /// motion independent of the order in which a scene was built.
  std::uint64_t order = 0;
  std::uint32_t body_a = BodyId::kNone;  ///< index into the world's bodies
  std::uint32_t body_b = BodyId::kNone;
  Vec3 normal = Vec3::UnitZ();  ///< world, unit, from a to b
  double radius_a = 0.0;        ///< m
  double radius_b = 0.0;        ///< m
  double friction = 0.5;        ///< Coulomb coefficient, >= 0
  double restitution = 0.0;     ///< 0 to 1
  int count = 0;                ///< points in use
  /// Another number where `key` names other shapes than before, so that a contact is not carried on
  /// by what has taken its place.
  std::uint32_t version = 0;
  /// Of a contact that was restored: fits all.
  static constexpr std::uint32_t kAnyVersion = 0xffffffffu;
  std::array<ManifoldPoint, kMaxPoints> points = {};
};

/// How far a body may go in the step that was just solved.
struct TANDEM_API MotionLimit {
  std::uint32_t body = 0;  ///< slot
  double share = 1.0;      ///< of the way from where the step began, below 1
  Pose pose = {};          ///< where it stays: an obstacle that moves on takes it along
  /// Unit, out of the obstacle: no speed against it stays. Zero: all of it stays, for the next
  /// step's contact.
  Vec3 normal = Vec3::UnitZ();
  Vec3 obstacle_moves = Vec3::Zero();  ///< m in the step
};

/// Anything that finds contacts. pbd knows no shapes; `collision` implements this.
class TANDEM_API ContactSource {
 public:
  virtual ~ContactSource() = default;

  /// Append the manifolds of this step to `out`, which keeps its capacity from step to step.
  /// Called once per step, before the first substep, with the poses as they are then.
  /// @param dt  length of the step to come, s: contacts that may close within it are wanted too.
  /// @param workers  may share the work; what is found must not depend on how many they are
  virtual void collect(const World& world, double dt, Workers& workers,
                       std::vector<Manifold>& out) = 0;

  /// Whether collect() would say again what it said last, of a world whose bodies all rest as they
  /// did then: it is not asked in a step in which nothing else happens either.
  virtual bool repeats() const { return false; }

  /// The last word against tunnelling: called with the poses (by slot) of all but static bodies at
  /// the end of a step, before they become the world's. Sets `limits` to the bodies that have to
  /// stop on their way, each once.
  virtual void limit_motion(const World& /*world*/, std::span<const Pose> /*after*/,
                            Workers& /*workers*/, std::vector<MotionLimit>& limits) {
    limits.clear();
  }

  /// A body is about to leave the world.
  virtual void remove_body(BodyId body) = 0;

  /// What the next collect() depends on besides the bodies' poses (caches included), for snapshots.
  virtual void save(ByteWriter& out) const = 0;
  /// The bytes may be anybody's: fail `in` where they are none of save().
  virtual void load(ByteReader& in) = 0;
  /// After load(): whether all bodies that it names are in the world.
  virtual bool fits(const World&) const { return true; }

  /// A source of the same kind and options that knows of no body, for WorldCopy; null where the
  /// kind cannot be copied.
  virtual std::unique_ptr<ContactSource> make_empty() const { return nullptr; }
  /// Become a deep copy of a source of the same kind: what it looks at, ids, caches, options. What
  /// never changes may be shared. Memory is used again: allocates only where the source has grown.
  /// @return false, and this source is as it was, where the other one is of another kind
  virtual bool assign(const ContactSource& /*source*/) { return false; }
};

}  // namespace tandem::pbd
