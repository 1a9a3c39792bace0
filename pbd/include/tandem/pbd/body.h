// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>

#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::pbd {

/// Names one body of one world. A slot is reused under a new generation, so a stale id is an error
/// and never names another body.
struct TANDEM_API BodyId {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t index = kNone;
  std::uint32_t generation = 0;

  bool valid() const { return index != kNone; }
  friend auto operator<=>(const BodyId&, const BodyId&) = default;
};

enum class BodyType : std::uint8_t {
  Static,     ///< never moves, infinite mass
  Kinematic,  ///< moves with the twist it was given, infinite mass
  Dynamic,    ///< moves under forces and constraints
};

/// World axes along and about which a body does not move, whatever acts on it. Locked rotation is
/// exact in every row; locked translation is enforced after each pass.
struct TANDEM_API AxisLocks {
  std::array<bool, 3> linear{};
  std::array<bool, 3> angular{};

  bool any() const {
    return linear[0] || linear[1] || linear[2] || angular[0] || angular[1] || angular[2];
  }
  friend bool operator==(const AxisLocks&, const AxisLocks&) = default;
};

/// How a body starts. Mass and inertia are read for dynamic bodies only.
struct TANDEM_API BodyDef {
  BodyType type = BodyType::Dynamic;
  Pose pose = {};                         ///< pose of the centre of mass
  Twist twist = {};                       ///< ignored for static bodies
  double mass = 1.0;                      ///< kg, > 0
  Mat3 inertia = Mat3::Identity() * 0.4;  ///< kg m^2, about the centre of mass, body frame
  double gravity_scale = 1.0;             ///< multiplies the world's gravity
  double linear_damping = 0.0;            ///< 1/s, >= 0: v decays as exp(-damping t)
  double angular_damping = 0.0;           ///< 1/s, >= 0
  AxisLocks locks = {};                   ///< dynamic bodies only
  bool bullet = false;    ///< CCD of its contacts along its path: for small, fast bodies
  bool can_sleep = true;  ///< may sleep with its island
  /// m/s and rad/s, 0 to 1e6: below these the body counts as at rest; they replace
  /// SolverOptions::sleep_speed and sleep_spin. An island sleeps when all of its bodies are at
  /// rest.
  std::optional<double> sleep_speed = {};
  std::optional<double> sleep_spin = {};
  /// A name for the body, unique in its world and the same in every world that has the body. See
  /// BodyOrder.
  std::optional<std::uint64_t> stable_id = {};
  std::uint64_t user_data = 0;  ///< see World::user_data()
  /// m, body frame: the application's origin of the body, which need not be the centre of mass.
  /// Tandem does not read it; snapshots include it.
  Vec3 origin = Vec3::Zero();
};

/// The state of a body between two steps.
struct TANDEM_API BodyState {
  Pose pose = {};
  Twist twist = {};
};

/// Axes in which an inertia tensor is diagonal.
struct TANDEM_API PrincipalAxes {
  /// Principal frame to body frame. z is the axis whose moment differs most from the others: the
  /// spin axis of a top.
  Quat frame = Quat::Identity();
  Vec3 moments = Vec3::Zero();  ///< kg m^2
};

/// Properties of a body; they change only through World.
struct TANDEM_API BodyProps {
  BodyType type = BodyType::Static;
  double mass = 0.0;                    ///< kg; 0 unless dynamic
  double inverse_mass = 0.0;            ///< 1/kg; 0 unless dynamic
  Mat3 inertia = Mat3::Zero();          ///< kg m^2, body frame
  Mat3 inverse_inertia = Mat3::Zero();  ///< 1/(kg m^2), body frame; 0 unless dynamic
  PrincipalAxes principal = {};         ///< principal axes of `inertia`
  double gravity_scale = 1.0;
  double linear_damping = 0.0;   ///< 1/s
  double angular_damping = 0.0;  ///< 1/s
  AxisLocks locks = {};
  bool bullet = false;
  bool can_sleep = true;
  std::optional<double> sleep_speed = {};  ///< m/s; none: SolverOptions::sleep_speed
  std::optional<double> sleep_spin = {};   ///< rad/s; none: SolverOptions::sleep_spin
  std::optional<std::uint64_t> stable_id = {};
  Vec3 origin = Vec3::Zero();  ///< m, body frame: see BodyDef::origin
};

/// State of a body that the solver keeps from step to step; zeros for one that has never moved.
struct TANDEM_API BodyActivity {
  bool asleep = false;
  std::uint8_t level = 0;  ///< refinement level: the island's substeps are doubled this often
  std::uint16_t steps_at_lower_level =
      0;                        ///< steps in a row for which a lower level would have done
  double low_speed_time = 0.0;  ///< s, time for which it has been slow
  // Motion since low_speed_time last passed a multiple of SolverOptions::sleep_after:
  Vec3 moved = Vec3::Zero();   ///< m
  Vec3 turned = Vec3::Zero();  ///< rad, a rotation vector while it is small

  /// Restarts the time for which the body has been slow.
  void stir() {
    low_speed_time = 0.0;
    moved.setZero();
    turned.setZero();
  }
};

/// The order in which bodies are taken wherever a result depends on an order: bodies with a stable
/// id by ascending id, then the others by slot. Slots follow the order of adding as long as no body
/// is removed. Two bodies never change places.
/// Worlds whose bodies have the same stable ids move alike bit for bit, in whatever order bodies,
/// colliders and constraints were added. Exception: colliders of one body, and constraints of one
/// kind between the same two bodies, keep the order in which they were added.
/// A view into its world, valid until bodies are added or removed.
class TANDEM_API BodyOrder {
 public:
  BodyOrder() = default;  ///< order of slots
  BodyOrder(std::span<const std::uint32_t> ranks, std::span<const std::uint32_t> slots)
      : ranks_(ranks), slots_(slots) {}

  /// Whether bodies are in the order of slots.
  bool natural() const { return ranks_.empty(); }
  /// Rank of a slot; BodyId::kNone is returned unchanged.
  std::uint32_t rank(std::uint32_t slot) const {
    return slot < ranks_.size() ? ranks_[slot] : slot;
  }
  std::uint32_t slot(std::uint32_t rank) const { return natural() ? rank : slots_[rank]; }
  /// Whether a constraint between bodies a and b comes before another one. Compared by body a, body
  /// b, then `index`; constraints to the world come first.
  bool row_before(BodyId a, BodyId b, std::uint32_t index, BodyId other_a, BodyId other_b,
                  std::uint32_t other_index) const {
    // The world comes first: its rank wraps round to 0.
    const auto place = [&](BodyId id) { return rank(id.index) + 1; };
    if (place(a) != place(other_a)) return place(a) < place(other_a);
    if (place(b) != place(other_b)) return place(b) < place(other_b);
    return index < other_index;
  }

 private:
  std::span<const std::uint32_t> ranks_;  ///< by slot; empty where slots are in order
  std::span<const std::uint32_t> slots_;  ///< by rank
};

/// Force (N) and torque about the centre of mass (N m), both in the world frame.
struct TANDEM_API Wrench {
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
};

}  // namespace tandem::pbd
