// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Contacts as the sweeps see them. What is included here is compiled for several instruction sets:
// no type whose layout depends on them may come in.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::pbd {

/// Rows that lie side by side, number by number: vector instructions take two or four at once.
inline constexpr std::size_t kLanes = 4;
struct alignas(32) Lanes : std::array<double, kLanes> {};
template <std::size_t n>
using LaneArray = std::array<Lanes, n>;
/// One bit for each lane.
using LaneMask = std::uint8_t;
inline constexpr LaneMask kAllLanes = (1u << kLanes) - 1u;

/// Up to four contacts that share no movable body: frames and mobilities of one step, multipliers
/// of one substep. Both bodies of a contact are seen from one point, the centre of pressure, in the
/// axes (normal, t1, t2): V is its relative velocity and W the relative spin. Point i approaches
/// with  V_n + s_i W_1 + r_i W_2, friction sees V_1, V_2 and W_n; all impulses add up to one force
/// and one couple there. Contacts of one point lie together, without what they do not need: the
/// point is the centre of pressure, so that s, r, the couple and the twist are 0.
/// Lanes that are not in use repeat the first one and move no body.
struct alignas(64) ContactRows {
  std::array<std::uint32_t, kLanes> a{};
  std::array<std::uint32_t, kLanes> b{};
  std::array<std::uint32_t, kLanes> contact{};  ///< index into the block's contacts
  std::uint8_t count = 0;                       ///< lanes in use
  bool faces = false;                           ///< two to four points each; else one
  LaneMask a_moves = 0;                         ///< a is not immovable
  LaneMask b_moves = 0;
  LaneMask penetrating = 0;  ///< some point overlaps
  LaneMask a_below = 0;      ///< a is nearer to what cannot move: it carries b
  LaneMask b_below = 0;
  bool bounces = false;  ///< some point of some contact does
  LaneMask joined = 0;   ///< a or b hangs on joints
  /// N s, sum of what the substep began with; before the first one, the share of the last step's
  Lanes carried{};
  Lanes approach{};  ///< m/s, fastest approach of a point before the substep, >= 0
  Lanes pressed{};   ///< N s, normal, sum over the substeps before this one
  Lanes fastest{};   ///< m/s, approach that an impulse stopped in one of them
  Lanes change{};    ///< m/s, of a normal velocity in the last sweep
  Lanes friction{};  ///< Coulomb
  LaneArray<3> normal{};
  LaneArray<3> t1{};
  LaneArray<3> arm_a{};  ///< m, world, centre of mass to centre of pressure
  LaneArray<3> arm_b{};
  LaneArray<2> slide{};  ///< N s, both passes
  // K, 6 x 6: how V and W answer an impulse and a couple at the centre of pressure. In blocks of
  // normal (n) and tangential (t) rows and columns; of impulses alone 1/kg, of couples alone
  // 1/(kg m^2), between both 1/(kg m). What faces have beside points is further down.
  Lanes k_nn{};            ///< of V_n to F_n
  LaneArray<3> k_tt{};     ///< of V_1, V_2 to F_1, F_2; symmetric: 11, 12, 22
  LaneArray<2> k_tn{};     ///< of V_1, V_2 to F_n
  LaneArray<4> impulse{};  ///< N s, normal, >= 0, of both passes
  /// m/s: > 0, the velocity at which the gap closes within the substep; < 0, minus the velocity at
  /// which the overlap is pushed open.
  LaneArray<4> bias{};
  LaneArray<4> bounce{};  ///< m/s, >= 0: normal velocity after an impact
  Lanes radii{};          ///< m, of both bodies, along the normal
  Lanes restitution{};
  Lanes fall{};  ///< m/s^2, >= 0: how gravity adds to the approach of the two

  Lanes points{};        ///< how many
  LaneArray<4> s{};      ///< m, along t2 from the centre of pressure
  LaneArray<4> r{};      ///< m, against t1
  LaneArray<4> reach{};  ///< m, from the centre of pressure
  /// Combination of the four impulses that changes no motion, of unit length.
  LaneArray<4> self_stress{};
  /// Of V_n, W_1, W_2 to F_n, T_1, T_2, beside k_nn; symmetric: n1, n2, 11, 12, 22
  LaneArray<5> k_nn_face{};
  /// Of V_1, V_2, W_n to F_n, T_1, T_2, beside k_tn: 11, 12, 21, 22, nn, n1, n2
  LaneArray<7> k_tn_face{};
  /// Of V_1, V_2, W_n to F_1, F_2, T_n, beside k_tt; symmetric: 1n, 2n, nn
  LaneArray<3> k_tt_face{};
  Lanes twist{};  ///< N m s, both passes

  std::size_t most_points() const { return faces ? 4 : 1; }
  /// N s
  double load(std::size_t lane) const {
    if (!faces) return impulse[0][lane];
    return (impulse[0][lane] + impulse[1][lane]) + (impulse[2][lane] + impulse[3][lane]);
  }
};

constexpr LaneMask lanes_in_use(const ContactRows& rows) {
  return static_cast<LaneMask>((1u << rows.count) - 1u);
}

/// Blows as they pass through the rows of a block, see ContactImpacts.
struct alignas(64) Blow {
  LaneArray<4> target{};   ///< m/s, normal velocity that this round asks of each point
  LaneArray<4> given{};    ///< N s, >= 0, by this round
  LaneArray<4> impulse{};  ///< N s, >= 0, by all rounds and what the substep began with
  Lanes change{};          ///< m/s, of a normal velocity in the last sweep; first, the approach
  LaneMask struck = 0;     ///< by any round
};

/// Share of an overlap that is opened in a substep.
inline constexpr double kPushGain = 0.6;

/// How gaps become velocities in a substep.
struct SubstepRule {
  double h = 0.0;               ///< s
  bool first = false;           ///< of its step: impulses come as forces, N
  double push_speed = 0.0;      ///< m/s, at most
  double push_slop = 0.0;       ///< m, overlap that is left alone
  double warm_start_gap = 0.0;  ///< m, carried impulses of wider gaps are dropped
  double bounce_speed = 0.0;    ///< m/s, slower impacts do not bounce
  /// m/s: a gap that closes no faster is none. By turns opened and closed, while friction is
  /// carried in part, such gaps rock what stands: a pyramid of 30 rows of 5 cm side by side fell
  /// after 8 s.
  double resting = 0.0;
  double growth = 0.0;  ///< m/s: an effective mass times this may be carried on in any case
};

/// Carried impulses grow by this factor in a substep at most, beyond SubstepRule::growth: an impact
/// is no load, and replayed in the next substep it would throw off again what has just landed. A
/// load builds up over a few substeps instead. But where two bodies still approach by more than
/// gravity adds, the impact is not over: all of it is carried on. Cut, boxes of 300 times the mass
/// that fall on a pyramid sink in by 133 mm and not 72, and cubes between the ground and one of 52
/// times theirs (katamari) overlap by up to 0.12 m and not 0.09.
inline constexpr double kGrowth = 2.0;

/// Which velocities a row asks for.
enum class ContactPass {
  Motion,    ///< the substep's: gaps may close but not overlap more
  Velocity,  ///< that of its end: none into the contact, bounces
};

/// Which of a body's velocities are meant.
enum class Velocities {
  Now,      ///< v, w
  Applied,  ///< v_applied, w_applied: only read
  Push,     ///< v_push, w_push
};

/// Where the kernels find what they read and write of bodies, as numbers:
/// v, w, 1/m and the inverse inertia (3, 3, 1 and 9 numbers), then x and q from the numbers kX and
/// kQ on, and v_applied, w_applied, v_push and w_push from `applied` on.
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

/// The anchors of contacts, where these have them: of a point a's (3 numbers), b's (3) and one that
/// is none; then the next point. Rows have no copy: they are read once a substep.
struct AnchorNumbers {
  static constexpr std::size_t kPoint = 7;
  const double* first = nullptr;
  std::size_t stride = 0;  ///< numbers, from contact to contact
  const double* of(std::uint32_t contact) const { return first + contact * stride; }
};

/// What is done with four rows at once. All widths give the same bits: lanes know nothing of each
/// other, and nothing is contracted.
struct ContactKernels {
  /// Responses, from frames, arms and the places of the points.
  /// @param asked  the rows meant
  void (*prepare)(ContactRows& rows, LaneMask asked, BodyNumbers bodies);
  /// Gaps and velocities of the substep's start, impulses as they are handed on to it. Friction is
  /// carried with them (kFrictionShare).
  void (*begin)(ContactRows& rows, const SubstepRule& rule, BodyNumbers bodies,
                AnchorNumbers anchors);
  /// Change v and w of both bodies as the rows' impulses do.
  void (*warm_start)(const ContactRows& rows, BodyNumbers bodies);
  /// Solve each row's normals, then its friction. Sets `change`.
  /// @param iterations  how often normals and friction take turns
  /// @param asked  the rows meant
  void (*solve)(ContactRows& rows, ContactPass pass, int iterations, LaneMask asked,
                BodyNumbers bodies);
  /// Open overlaps through v_push and w_push, which move poses and are forgotten after the substep.
  /// What lies below counts as no lighter than what lies on it, as if the ground helped: pushed
  /// into what it stands on, a light body would never get a heavy one off. Boxes of 300 times the
  /// mass that fall on a pyramid end 1 mm deep instead of 0.3 m.
  /// @param asked  the rows that have a say
  /// @return those that did something
  LaneMask (*push)(const ContactRows& rows, LaneMask asked, BodyNumbers bodies);
  /// The same in islands with a target, where v_push and w_push go to the targets as well: of a gap
  /// they may have what the substep's own motion leaves. Masses count as they are: with the rule
  /// above a roller of 12 kg among cubes of 0.1 kg is lifted by 130 J in 10 s and falls again.
  LaneMask (*hold)(const ContactRows& rows, LaneMask asked, BodyNumbers bodies);
  /// Begin a round of blows: what it asks of each point, for bodies that move with v_push and
  /// w_push.
  /// @param slow   m/s, what approaches no faster is not hit
  /// @param first  the approach before the substep is meant: only what bounces is hit
  /// @return the rows that are hit; `change` is how fast they approach
  LaneMask (*meet)(const ContactRows& rows, Blow& blow, double slow, bool first,
                   BodyNumbers bodies);
  /// Sweep over a round: change v_push and w_push as its blows do. Sets `change`.
  void (*strike)(const ContactRows& rows, Blow& blow, LaneMask asked, BodyNumbers bodies);
  /// Rows that were struck take over the impulses of their blows, and bounce as these left them.
  void (*settle)(ContactRows& rows, const Blow& blow, BodyNumbers bodies);
};

/// Where a step begins, with points and arms of its own, normals and friction take turns as often:
/// with one turn a pyramid of 50 rows without gaps drifts by 2.8 mm, with two by 1.7. Elsewhere
/// once is enough.
constexpr int normal_friction_iterations(bool first_substep) { return first_substep ? 2 : 1; }

/// @param width  rows at once: 2 or 4; 0, as many as this processor can
const ContactKernels& contact_kernels(int width);
/// The widest that this build and this processor have.
int widest_kernels();

}  // namespace tandem::pbd
