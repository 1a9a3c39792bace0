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
/// normal is measured between them, minus the manifold's two radii.
struct TANDEM_API ManifoldPoint {
  Vec3 anchor_a_l = Vec3::Zero();  ///< m, frame of body a
  Vec3 anchor_b_l = Vec3::Zero();  ///< m, frame of body b
  std::uint32_t feature = 0;       ///< same value = same pair of features as in the last step
};

/// Contact of one pair of convex parts: handed from the detector to the solver, once per step.
/// gap_i = normal . (p_b,i - p_a,i) - radius_a - radius_b  [m], negative where they overlap.
/// A round part (sphere, capsule) gives its centre or axis point as anchor and its radius here, so
/// that the gap does not change when it rolls.
struct TANDEM_API Manifold {
  static constexpr int kMaxPoints = 4;

  /// Identifies the pair, the same in every step.
  std::uint64_t key = 0;
  /// Manifolds are solved in ascending order of this; ties are solved by key. It may change from
  /// step to step as long as no two manifolds change places. A source that follows World::order()
  /// makes motion independent of the order in which a scene was built.
  std::uint64_t order = 0;
  std::uint32_t body_a = BodyId::kNone;  ///< index into the world's bodies
  std::uint32_t body_b = BodyId::kNone;
  Vec3 normal = Vec3::UnitZ();  ///< world, unit, from a to b
  double radius_a = 0.0;        ///< m
  double radius_b = 0.0;        ///< m
  double friction = 0.5;        ///< Coulomb coefficient, >= 0
  double restitution = 0.0;     ///< 0 to 1
  int count = 0;                ///< points in use
  /// Changes when `key` is given to other shapes, so that the new contact does not inherit the
  /// state of the old one.
  std::uint32_t version = 0;
  /// Matches any version; set in a restored contact.
  static constexpr std::uint32_t kAnyVersion = 0xffffffffu;
  std::array<ManifoldPoint, kMaxPoints> points = {};
};

/// Bound on a body's motion in the step that was just solved (CCD).
struct TANDEM_API MotionLimit {
  std::uint32_t body = 0;  ///< slot
  double share = 1.0;      ///< fraction of its motion in the step, below 1
  Pose pose = {};          ///< where it stops: a moving obstacle carries it along
  /// Unit, out of the obstacle: velocity against it is removed. Zero: the velocity stays, for the
  /// next step's contact.
  Vec3 normal = Vec3::UnitZ();
  Vec3 obstacle_moves = Vec3::Zero();  ///< m, motion of the obstacle in the step
};

/// Finds contacts. pbd knows no shapes; `collision` implements this.
class TANDEM_API ContactSource {
 public:
  virtual ~ContactSource() = default;

  /// Append the manifolds of this step to `out`, which keeps its capacity from step to step.
  /// Called once per step, before the first substep, with the poses as they are then.
  /// @param dt  length of the coming step, s: contacts that may close within it are wanted, too
  /// @param workers  may share the work; the result must not depend on their number
  virtual void collect(const World& world, double dt, Workers& workers,
                       std::vector<Manifold>& out) = 0;

  /// Whether collect() would return its last result again for a world whose bodies all rest as they
  /// did then. If so, it is not called in a step without other changes.
  virtual bool repeats() const { return false; }

  /// The final CCD clamp: called at the end of a step with the poses (by slot) of all non-static
  /// bodies, before they become the world's. Sets `limits` to the bodies that must stop on their
  /// way, each once.
  virtual void limit_motion(const World& /*world*/, std::span<const Pose> /*after*/,
                            Workers& /*workers*/, std::vector<MotionLimit>& limits) {
    limits.clear();
  }

  /// A body is about to be removed.
  virtual void remove_body(BodyId body) = 0;

  /// Everything that the next collect() depends on besides the bodies' poses (caches included), for
  /// snapshots.
  virtual void save(ByteWriter& out) const = 0;
  /// The input is untrusted: fail `in` if it is not from save().
  virtual void load(ByteReader& in) = 0;
  /// After load(): whether all named bodies are in the world.
  virtual bool fits(const World&) const { return true; }

  /// An empty source of the same kind and options, for WorldCopy; null if the kind cannot be
  /// copied.
  virtual std::unique_ptr<ContactSource> make_empty() const { return nullptr; }
  /// Become a deep copy of a source of the same kind: colliders, ids, caches, options. Immutable
  /// data may be shared. Memory is reused: allocates only if the source has grown.
  /// @return false, leaving this source as it was, if the other one is of another kind
  virtual bool assign(const ContactSource& /*source*/) { return false; }
};

}  // namespace tandem::pbd
