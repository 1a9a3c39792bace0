// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/manifold.h"

namespace tandem::pbd {

/// How contacts are solved; part of SolverOptions.
struct TANDEM_API ContactOptions {
  /// m/s, bound on the speed of pushing overlapping bodies apart: 0.6 of the overlap per substep.
  /// Small overlaps are pushed in every other substep and in the last. The push moves poses and
  /// never enters velocity. It saturates at this speed, at 7 mm of overlap for 1 m/s: cubes at the
  /// bottom of a heap of 8000 overlap by 135 mm with 1 m/s, by 42 mm with 4.
  double push_speed = 4.0;
  /// m: carried multipliers warm start the sweep where the gap is below this.
  double warm_start_gap = 1e-3;
  /// Budget of rows solved beyond the solver's substeps in a step. Islands that want more substeps
  /// come first; if all their rows in all further substeps exceed it, each gets a share. A sixth of
  /// what is left goes to rows that one sweep has not solved: they are swept further, those with
  /// the fastest bodies first, until no normal velocity changes by more than `resting_tolerance`
  /// times what gravity adds in a substep. A gap that closes no faster than that is not an
  /// approach.
  /// Unconverged contacts rock stacks: a tower of ten cubes of 10 cm, each a few millimetres off
  /// the one below, swayed by 2 mm without end at 0.01, and walked by 3 cm in 30 s. Propagating
  /// impacts may take another sixth. BlockReport tells the rows solved and left.
  int extra_rows = 24000;
  /// Further sweeps over the same rows in a substep; warm starts carry the rest on to the next one.
  /// Without a limit, a plate of stacks that two people carry (demo cubes) takes 1.6 times as long
  /// for the same copies and overlaps. With 16, two of 24 towers that were touched rock on
  /// (tests/scene/heap_rest_test.cpp).
  int extra_sweeps = 32;
  double resting_tolerance = 0.001;
  /// Impacts slower than this many times what gravity adds in a substep do not bounce. Gravity
  /// counts as at least 1 m/s^2, here and above, so that floating bodies come to rest too.
  double restitution_threshold = 2.0;
  /// Rows solved at once by vector instructions, 2 or 4; 0: as many as the processor can. The bits
  /// are the same.
  int lanes = 0;

  friend bool operator==(const ContactOptions&, const ContactOptions&) = default;
};

/// One manifold of a step and the state carried with it from step to step.
struct TANDEM_API Contact {
  Manifold manifold = {};
  std::array<double, 4> force{};       ///< N, normal, of the last substep; >= 0
  Vec3 friction_force = Vec3::Zero();  ///< N, world, on body b, of the last substep
  /// Friction that the next step starts from, smoothed over steps: N, world, on body b, and N m
  /// about the normal.
  Vec3 carried_friction = Vec3::Zero();
  double carried_twist = 0.0;
  /// The part of the force that the next step starts from: less after an impact.
  double warm_start_scale = 1.0;
  /// m/s, fastest approach that an impulse stopped in the last step; >= 0
  double approach_speed = 0.0;
  double impulse = 0.0;   ///< N s, normal, sum over points and substeps of the last step
  double overlap = -1.0;  ///< m, >= 0, at the end of the last step; below 0: unknown

  /// Saves all but the pair's identity (key, order, bodies).
  void save(ByteWriter& out) const;
  /// The input is untrusted: fails `in` on values that no contact can have.
  void load(ByteReader& in);
  /// Whether any point carried a load in the last substep.
  bool loaded() const {
    return force[0] > 0.0 || force[1] > 0.0 || force[2] > 0.0 || force[3] > 0.0;
  }
};

/// Summary of a contact for passes over all of them: a whole contact is seven cache lines.
struct ContactBrief {
  std::uint32_t a = 0, b = 0;  ///< bodies
  bool face = false;           ///< more than one point
  bool loaded = false;         ///< Contact::loaded()
  bool is_new = false;         ///< absent in the last step
  bool rubs = false;           ///< its friction coefficient is above 0
};

/// All contacts of a world, one per manifold of the last detection, stored by ascending key and
/// solved in the order of their manifolds.
///
/// C_i = normal . (p_b,i - p_a,i) - radius_a - radius_b  [m];  C >= 0, lambda >= 0, C lambda = 0.
/// All normals of a manifold are solved together, as a linear complementarity problem of up to four
/// unknowns. Friction acts at their centre of pressure, as a 2x2 block in the tangent plane and a
/// row of twist about the normal. Both are solved for the velocity of the substep: with Jacobians
/// that are constant over the step (the substep, if a body tumbles), moving a pose by h dv equals
/// projecting C(x + h v), and no orientation is renewed within a sweep. Gaps are measured from the
/// anchors once per substep. Friction undoes the displacement of the substep, with |lambda_t| <= mu
/// sum(lambda_i): the multiplier is clamped to the cone, not skipped outside it. The velocity pass
/// continues with the same multiplier, because stopping normal velocities makes a tilted body
/// slide. Source: [mueller2020] Sec. 3.5 and 3.6. Differs: as above, plus warm start and a velocity
/// pass with accumulated clamping.
class TANDEM_API ContactBlock final : public ConstraintBlock {
 public:
  ContactBlock();
  ~ContactBlock() override;

  /// Takes this step's manifolds (any order; left empty). Forces carry over from the last contact
  /// of the same pair, point by point: same feature, else nearest anchor.
  void set_manifolds(std::vector<Manifold>& manifolds, Workers& workers);
  /// Takes contacts that another block has solved until now: the next set_manifolds() carries them
  /// over as if they had been in this block. Pairs that are here already are skipped.
  void adopt(std::span<const Contact> contacts);
  void configure(const ContactOptions& options);
  std::span<const Contact> contacts() const;
  /// Summaries of contacts(), in the same order.
  std::span<const ContactBrief> briefs() const;
  bool any_friction() const;     ///< some contact has a coefficient above 0
  bool any_restitution() const;  ///< some contact has a restitution above 0

  std::string_view name() const override { return "contact"; }
  int order() const override { return static_cast<int>(SolveOrder::Contact); }
  bool empty() const override;
  bool groups_at_once() const override { return true; }
  void begin_step(const SubstepContext& ctx) override;
  void begin_substep(const SubstepContext& ctx) override;
  void warm_start(const SubstepContext& ctx) override;
  double project(const SubstepContext& ctx) override;
  double solve_velocity(const SubstepContext& ctx) override;
  void finish_velocity(const SubstepContext& ctx) override;
  double project_displacement(const SubstepContext& ctx) override;
  void end_step(const SubstepContext& ctx, std::span<double> wanted) override;
  /// Bodies that have lost a loaded contact: a collider was removed or filtered, or the support was
  /// moved away.
  void take_changed(std::vector<std::uint32_t>& bodies) override;
  /// Contacts that carry a load support their bodies.
  void append_edges(std::vector<ConstraintEdge>& edges) const override;
  void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const override;
  void remove_body(BodyId body) override;
  BlockReport report() const override;
  void save(ByteWriter& out) const override;
  void load(ByteReader& in) override;
  bool fits(const World& world) const override;
  std::unique_ptr<ConstraintBlock> make_empty() const override;
  bool assign(const ConstraintBlock& source) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::pbd
