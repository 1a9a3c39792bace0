// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Contacts as the sweeps see them. Included by sources for several instruction sets: no type whose
// layout depends on them may be used here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::pbd {

/// Lanes: rows stored number by number; vector instructions take two or four at once.
inline constexpr std::size_t kLanes = 4;
struct alignas(32) Lanes : std::array<double, kLanes> {};
template <std::size_t n>
using LaneArray = std::array<Lanes, n>;
/// One bit per lane.
using LaneMask = std::uint8_t;
inline constexpr LaneMask kAllLanes = (1u << kLanes) - 1u;

/// Up to four contacts that share no movable body: frames and mobilities of one step, multipliers
/// of one substep. Both bodies of a contact are seen from the centre of pressure, in the axes
/// (normal, t1, t2): V is the relative velocity there and W the relative spin. Point i approaches
/// with  V_n + s_i W_1 + r_i W_2; friction acts on V_1, V_2 and W_n; all impulses sum to one force
/// and one couple. Single points are stored in blocks of their own, without face data: the point is
/// the centre of pressure, so that s, r, the couple and the twist are 0.
/// Unused lanes repeat the first one and move no body.
struct alignas(64) ContactRows {
  std::array<std::uint32_t, kLanes> a{};
  std::array<std::uint32_t, kLanes> b{};
  std::array<std::uint32_t, kLanes> contact{};  ///< index into the block's contacts
  std::uint8_t count = 0;                       ///< lanes in use
  bool faces = false;                           ///< two to four points each; else one
  LaneMask a_moves = 0;                         ///< a is movable
  LaneMask b_moves = 0;
  LaneMask penetrating = 0;  ///< some point overlaps
  LaneMask a_below = 0;      ///< a is nearer to an immovable body: it carries b
  LaneMask b_below = 0;
  bool bounces = false;  ///< some point of some contact bounces
  LaneMask joined = 0;   ///< a or b has joints
  /// N s, sum at the start of the substep; before the first one, the share of the last step's
  Lanes carried{};
  Lanes approach{};  ///< m/s, fastest approach of a point before the substep, >= 0
  Lanes pressed{};   ///< N s, normal, sum over the previous substeps
  Lanes fastest{};   ///< m/s, fastest approach that an impulse stopped in them
  Lanes change{};    ///< m/s, change of a normal velocity in the last sweep
  Lanes friction{};  ///< Coulomb
  LaneArray<3> normal{};
  LaneArray<3> t1{};
  LaneArray<3> arm_a{};  ///< m, world, centre of mass to centre of pressure
  LaneArray<3> arm_b{};
  LaneArray<2> slide{};  ///< N s, of both passes
  // K, 6 x 6: response of V and W to an impulse and a couple at the centre of pressure. In blocks
  // of normal (n) and tangential (t) rows and columns; impulse to velocity 1/kg, couple to spin
  // 1/(kg m^2), mixed 1/(kg m). Further entries for faces are below.
  Lanes k_nn{};            ///< V_n to F_n
  LaneArray<3> k_tt{};     ///< V_1, V_2 to F_1, F_2; symmetric: 11, 12, 22
  LaneArray<2> k_tn{};     ///< V_1, V_2 to F_n
  LaneArray<4> impulse{};  ///< N s, normal, >= 0, of both passes
  /// m/s: > 0, velocity at which the gap closes within the substep; < 0, minus the velocity at
  /// which the overlap is opened.
  LaneArray<4> bias{};
  LaneArray<4> bounce{};  ///< m/s, >= 0: normal velocity after an impact
  Lanes radii{};          ///< m, sum of both bodies', along the normal
  Lanes restitution{};
  Lanes fall{};  ///< m/s^2, >= 0: approach of the two by gravity

  Lanes points{};        ///< number of points
  LaneArray<4> s{};      ///< m, along t2 from the centre of pressure
  LaneArray<4> r{};      ///< m, against t1
  LaneArray<4> reach{};  ///< m, from the centre of pressure
  /// Combination of the four impulses without effect on motion, of unit length.
  LaneArray<4> self_stress{};
  /// V_n, W_1, W_2 to F_n, T_1, T_2, besides k_nn; symmetric: n1, n2, 11, 12, 22
  LaneArray<5> k_nn_face{};
  /// V_1, V_2, W_n to F_n, T_1, T_2, besides k_tn: 11, 12, 21, 22, nn, n1, n2
  LaneArray<7> k_tn_face{};
  /// V_1, V_2, W_n to F_1, F_2, T_n, besides k_tt; symmetric: 1n, 2n, nn
  LaneArray<3> k_tt_face{};
  Lanes twist{};  ///< N m s, of both passes

  std::size_t most_points() const { return faces ? 4 : 1; }
  /// N s, normal impulse of the lane.
  double load(std::size_t lane) const {
    if (!faces) return impulse[0][lane];
    return (impulse[0][lane] + impulse[1][lane]) + (impulse[2][lane] + impulse[3][lane]);
  }
};

constexpr LaneMask lanes_in_use(const ContactRows& rows) {
  return static_cast<LaneMask>((1u << rows.count) - 1u);
}

/// Impacts that propagate through the rows of a block, see ContactImpacts.
struct alignas(64) Blow {
  LaneArray<4> target{};   ///< m/s, normal velocity of each point that this round aims at
  LaneArray<4> given{};    ///< N s, >= 0, impulse of this round
  LaneArray<4> impulse{};  ///< N s, >= 0, of all rounds and at the start of the substep
  Lanes change{};          ///< m/s, of a normal velocity in the last sweep; first, the approach
  LaneMask struck = 0;     ///< hit in any round
};

/// Share of an overlap that is opened in a substep.
inline constexpr double kPushGain = 0.6;

/// How gaps become velocities in a substep.
struct SubstepRule {
  double h = 0.0;               ///< s
  bool first = false;           ///< first of its step: impulses are given as forces, N
  double push_speed = 0.0;      ///< m/s, at most
  double push_slop = 0.0;       ///< m, overlap that is left alone
  double warm_start_gap = 0.0;  ///< m, carried impulses at wider gaps are dropped
  double bounce_speed = 0.0;    ///< m/s, slower impacts do not bounce
  /// m/s: slower closing of a gap is no approach. Such gaps would open and close in turn and, as
  /// friction is only partly carried, rock stacks: a pyramid of 30 rows of 5 cm side by side fell
  /// after 8 s.
  double resting = 0.0;
  double growth = 0.0;  ///< m/s: an effective mass times this may always be carried on
};

/// Carried impulses grow by at most this factor in a substep, beyond SubstepRule::growth. An impact
/// is no load: replayed in the next substep it would throw off what has just landed. A load builds
/// up over a few substeps instead. But if two bodies still approach by more than gravity adds, the
/// impact is not over and all of it is carried on. Otherwise boxes of 300 times the mass that fall
/// on a pyramid sink in by 133 mm and not 72, and cubes between the ground and one of 52 times
/// theirs (katamari) overlap by up to 0.12 m and not 0.09.
inline constexpr double kGrowth = 2.0;

/// The velocities that a row prescribes.
enum class ContactPass {
  Motion,    ///< of the substep: gaps may close but not overlap more
  Velocity,  ///< at its end: none into the contact; impacts bounce
};

/// Which of a body's velocities are used.
enum class Velocities {
  Now,      ///< v, w
  Applied,  ///< v_applied, w_applied: read only
  Push,     ///< v_push, w_push
};

/// Numbers of bodies that the kernels read and write: v, w, 1/m and the inverse inertia (3, 3, 1
/// and 9 numbers), then x and q from the numbers kX and kQ on, and v_applied, w_applied, v_push and
/// w_push from `applied` on.
struct BodyNumbers {
  static constexpr std::size_t kX = 16;
  static constexpr std::size_t kQ = 19;
  double* first = nullptr;
  std::size_t stride = 0;   ///< numbers, from body to body
  std::size_t applied = 0;  ///< numbers, from v to v_applied
  double* of(std::uint32_t body) const { return first + body * stride; }
  std::size_t of_velocities(Velocities which) const {
    return which == Velocities::Now ? 0 : which == Velocities::Applied ? applied : applied + 6;
  }
};

/// The anchors in contacts: for each point a's (3 numbers), b's (3) and one of padding. Rows have
/// no copy, as anchors are read once a substep.
struct AnchorNumbers {
  static constexpr std::size_t kPoint = 7;
  const double* first = nullptr;
  std::size_t stride = 0;  ///< numbers, from contact to contact
  const double* of(std::uint32_t contact) const { return first + contact * stride; }
};

/// Operations on four rows at once. All widths give the same bits: lanes are independent, and no
/// multiply-add is contracted.
struct ContactKernels {
  /// Computes the responses from frames, arms and the points.
  /// @param asked  the rows to prepare
  void (*prepare)(ContactRows& rows, LaneMask asked, BodyNumbers bodies);
  /// Computes gaps and velocities at the start of the substep and the impulses carried on to it,
  /// friction included (kFrictionShare).
  void (*begin)(ContactRows& rows, const SubstepRule& rule, BodyNumbers bodies,
                AnchorNumbers anchors);
  /// Applies the rows' impulses to v and w of both bodies.
  void (*warm_start)(const ContactRows& rows, BodyNumbers bodies);
  /// Solves each row's normals, then its friction. Sets `change`.
  /// @param iterations  alternations of normals and friction
  /// @param asked  the rows to solve
  void (*solve)(ContactRows& rows, ContactPass pass, int iterations, LaneMask asked,
                BodyNumbers bodies);
  /// Opens overlaps with v_push and w_push, which move poses and are dropped after the substep. The
  /// lower body counts as no lighter than the upper one, as if the ground supported it: pushed into
  /// its support, a light body would never get a heavy one off. Boxes of 300 times the mass that
  /// fall on a pyramid end 1 mm deep instead of 0.3 m.
  /// @param asked  the rows to solve
  /// @return the rows that changed a velocity
  LaneMask (*push)(const ContactRows& rows, LaneMask asked, BodyNumbers bodies);
  /// Like push, in islands with a target, whose v_push and w_push include motion to targets: it may
  /// use the part of a gap that the substep's own motion leaves. Masses count as they are: with
  /// push's rule a roller of 12 kg among cubes of 0.1 kg is lifted by 130 J in 10 s and falls
  /// again.
  LaneMask (*hold)(const ContactRows& rows, LaneMask asked, BodyNumbers bodies);
  /// Begins a round of impacts: sets the target of each point, for bodies that move with v_push and
  /// w_push.
  /// @param slow   m/s, slower approaches are not hit
  /// @param first  use the approach before the substep: only bounces are hit
  /// @return the rows that are hit; `change` is their approach
  LaneMask (*meet)(const ContactRows& rows, Blow& blow, double slow, bool first,
                   BodyNumbers bodies);
  /// Sweeps over a round: applies its impulses to v_push and w_push. Sets `change`.
  void (*strike)(const ContactRows& rows, Blow& blow, LaneMask asked, BodyNumbers bodies);
  /// Commits impacts: rows that were hit take over their impulses and bounce accordingly.
  void (*settle)(ContactRows& rows, const Blow& blow, BodyNumbers bodies);
};

/// Alternations of normals and friction. More in the first substep of a step, with new points and
/// arms: with one a pyramid of 50 rows without gaps drifts by 2.8 mm, with two by 1.7. Elsewhere
/// one is enough.
constexpr int normal_friction_iterations(bool first_substep) { return first_substep ? 2 : 1; }

/// @param width  rows at once: 2 or 4; 0, as many as this processor can
const ContactKernels& contact_kernels(int width);
/// Largest width of this build and processor.
int widest_kernels();

}  // namespace tandem::pbd
