// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "joint_rows.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/joint_gap.h"

namespace tandem::pbd {

/// State of a ball drive in the substep; see JointRecord::begin_drive().
struct JointDrive {
  Quat start = Quat::Identity();  ///< frame b to frame a at the start of the substep
  Vec3 left = Vec3::Zero();       ///< rad, from there to the target of its motor
};

/// Where a joint is at the start of a step.
struct JointStart {
  double twist = 0.0;        ///< rad
  Vec3 spin = Vec3::Zero();  ///< rad/s, of b relative to a
};

/// What the last substep leaves for the next one.
struct JointLast {
  double h = 0.0;  ///< s, its length; 0 before the first
  /// N or N m, of each coordinate's row, on body b.
  std::array<double, kCoordinates> forces{};
  /// m/s or rad/s, of rotors: of coordinates with an armature, as their rows have moved them. Later
  /// rows move the bodies, but no rotor.
  std::array<double, kCoordinates> rotors{};
  bool rotors_known = false;  ///< else they turn with the bodies
};

struct JointRecord {
  SixDofJointDef def;
  JointState state;
  /// Left by agreement and later rows, per coordinate.
  std::array<double, kCoordinates> displacement_residual{};
  std::array<double, kCoordinates> bound{};  ///< value at which the displacement channel holds it
  JointLast last;
  double twist = 0.0;  ///< rad, about axis `turning`, counting turns
  /// kg or kg m^2, per coordinate whose spring has a frequency; see weigh_springs().
  std::array<double, kCoordinates> spring_mass{};
  JointGap gap;  ///< state of the gap in displacement_residual
  /// J: gain of the part whose first joint this is; in a part with loops, for its second joint, the
  /// energy that contacts may still lose. See limit_energy_gain().
  double energy_excess = 0.0;
  JointStart before;   ///< at the start of the step
  bool broke = false;  ///< in this step
  JointDrive drive;
  /// Effective settings of each coordinate: friction as a motor at speed 0, and springs of a
  /// frequency with their stiffness and damping. Those of the drive have rest and target from
  /// begin_drive() on.
  std::array<JointAxis, kCoordinates> axes{};
  std::uint32_t used = 0;     ///< bits of coordinates that may get a row
  std::uint32_t in_part = 0;  ///< bits of coordinates that the last substep has solved only in part
  int turning = 0;            ///< the only free angular axis; 0 (x) if there is none
  bool point = false;         ///< all displacements locked alike: rows along the world's axes
  bool passive = true;        ///< it neither stores nor supplies energy
  bool alive = false;

  bool active() const { return alive && def.enabled && !state.broken; }
  /// Takes a definition over, by refresh(); rotors that change turn with the bodies again.
  void assign(const SixDofJointDef& from);
  /// Recomputes `axes`, `used`, `turning`, `point` and `passive` from the definition;
  /// unused coordinates lose their residual.
  void refresh();
  /// The coordinate of turns about `turning` (0), and of the axes after it (1, 2).
  int turn(int i) const { return kTwist + (turning + i) % 3; }
  const JointAxis& turning_axis() const { return def.angular[static_cast<std::size_t>(turning)]; }
  /// Sets its forces in this step to 0.
  void clear_forces();
  /// Writes all coordinates to the state.
  void tell(const SolverBody& a, const double* c);
  /// Initialises a new joint from the poses of its bodies: it takes the turn within its limits.
  void start(const SolverBody& a, const SolverBody& b);
  /// Treats the current violation as left by agreement.
  void forgive(const SolverBody& a, const SolverBody& b);
  /// Before the step: violation that was made since the last one becomes gap, on the turn that lies
  /// within the limits.
  /// @param displaced  agreement has made all of it
  void find_gap(const SolverBody& a, const SolverBody& b, bool displaced);
  /// Displacement channel: sets `bound` to the values that rows aim at by its end (s), and the
  /// residual to the rest.
  void aim(const SolverBody& a, const SolverBody& b, double substep);
  /// Updates the gap after the step.
  void settle_gap();
  const JointAxis& axis(int c) const { return axes[static_cast<std::size_t>(c)]; }
  /// Sets `axes` from the definition and the masses of the springs.
  void resolve();
  /// At the start of the substep: sets the reference of the drive's turns and the way to its ends.
  void begin_drive(const SolverBody& a, const SolverBody& b, double substep);
  int rows() const { return std::popcount(used); }
  /// Number of rows that a plan reserves: one more for a motor that may be switched on.
  int room() const { return is_point() ? rows() : std::min(rows() + 1, kCoordinates); }
  /// Whether it has the three rows of a point and no others.
  bool is_point() const { return point && used == 7u; }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);
};

/// Coordinates of a joint at the current poses; those about `turning` within half a turn of `near`.
/// Points have displacements only.
void coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b, double near,
                 double* c);
void all_coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b,
                     double near, double* c);

/// The body of an id; the immovable `ground` for the world.
inline const SolverBody& body_of(BodyId id, std::span<const SolverBody> bodies,
                                 const SolverBody& ground) {
  return id.valid() ? bodies[id.index] : ground;
}

/// Visits the indices of the set bits, lowest first.
void for_bits(std::uint32_t bits, auto&& visit) {
  for (; bits != 0; bits &= bits - 1) visit(std::countr_zero(bits));
}

}  // namespace tandem::pbd
