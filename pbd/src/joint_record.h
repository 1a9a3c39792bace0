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

/// A joint as the block stores it.
/// The drive of a ball as of the substep; see JointRecord::begin_drive().
struct JointDrive {
  Quat start = Quat::Identity();  ///< frame b to frame a when the substep began
  Vec3 left = Vec3::Zero();       ///< rad, to the target of its motor from there
  std::array<JointAxis, 3> axes{};
};

struct JointRecord {
  SixDofJointDef def;
  JointState state;
  /// What agreement and later rows left of each coordinate.
  std::array<double, kCoordinates> displacement_residual{};
  std::array<double, kCoordinates> bound{};  ///< where the displacement channel holds it
  /// N or N m, of each coordinate's row in the last substep, on body b.
  std::array<double, kCoordinates> forces{};
  double twist = 0.0;  ///< rad, about axis `turning`, counting turns
  /// kg or kg m^2, of each coordinate whose spring has a frequency; see weigh_springs().
  std::array<double, kCoordinates> spring_mass{};
  JointGap gap;  ///< of its displacement_residual
  /// J, what the part that it comes first in has gained; what contacts have left to lose where it
  /// comes second in a part with loops. See limit_energy_gain().
  double energy_excess = 0.0;
  double h = 0.0;             ///< s, length of the last substep; 0 before the first
  double twist_before = 0.0;  ///< rad, twist when the step began
  bool broke = false;         ///< in this step
  Vec3 spin = Vec3::Zero();   ///< rad/s, of b against a when the step began
  JointDrive drive;
  std::uint32_t used = 0;     ///< bit per coordinate that may get a row
  std::uint32_t in_part = 0;  ///< bit per coordinate that the last substep has solved in part only
  int turning = 0;            ///< the angular axis that is free alone; 0 (x) where none is
  bool point = false;         ///< all displacements locked alike: rows along the world's axes
  bool passive = true;        ///< nothing in it stores or supplies energy
  bool alive = false;

  bool active() const { return alive && def.enabled && !state.broken; }
  /// Recompute `used`, `turning`, `point` and `passive` from the definition; what is not used keeps
  /// no residual.
  void refresh();
  /// The coordinate of turns about `turning` (0), and of the axes that follow it (1, 2).
  int turn(int i) const { return kTwist + (turning + i) % 3; }
  const JointAxis& turning_axis() const { return def.angular[static_cast<std::size_t>(turning)]; }
  /// It has none in this step.
  void clear_forces();
  /// All coordinates into the state.
  void tell(const SolverBody& a, const double* c);
  /// The bodies of a joint that is new stand like that: it takes the turn within its limits.
  void start(const SolverBody& a, const SolverBody& b);
  /// What is violated is what agreement has left.
  void forgive(const SolverBody& a, const SolverBody& b);
  /// Before the step: what somebody has put elsewhere since the last one becomes gap, on the turn
  /// that lies within its limits.
  /// @param displaced  all that is violated is what agreement did
  void find_gap(const SolverBody& a, const SolverBody& b, bool displaced);
  /// Displacement channel: set `bound` to where the rows may be at the end of it (s), and the
  /// residual to what they are then to leave.
  void aim(const SolverBody& a, const SolverBody& b, double substep);
  /// After the step.
  void settle_gap();
  /// The settings of coordinate c: friction as a motor that stands, and springs of a frequency with
  /// their stiffness and damping as well.
  JointAxis axis(int c) const;
  /// As the substep begins: what turns of the drive are measured from and how far it is to its
  /// ends.
  void begin_drive(const SolverBody& a, const SolverBody& b, double substep);
  int rows() const { return std::popcount(used); }
  /// How many rows a plan has room for: with that of a motor which is switched on meanwhile.
  int room() const { return is_point() ? rows() : std::min(rows() + 1, kCoordinates); }
  /// Three rows of a point and no others.
  bool is_point() const { return point && used == 7u; }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);
};

/// Coordinates of a joint as its bodies stand now, those about `turning` within half a turn of
/// `near`; of points, displacements alone.
void coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b, double near,
                 double* c);
void all_coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b,
                     double near, double* c);

/// The body of an id; `ground`, which nothing moves, where that stands for the world.
inline const SolverBody& body_of(BodyId id, std::span<const SolverBody> bodies,
                                 const SolverBody& ground) {
  return id.valid() ? bodies[id.index] : ground;
}

/// Visit the indices of the bits that are set, lowest first.
void for_bits(std::uint32_t bits, auto&& visit) {
  for (; bits != 0; bits &= bits - 1) visit(std::countr_zero(bits));
}

}  // namespace tandem::pbd
