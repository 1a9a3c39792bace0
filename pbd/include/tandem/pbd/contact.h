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
  /// m/s: bodies that overlap are pushed apart by 0.6 of the overlap in each substep, but no faster
  /// than this; where they hardly do, in every other substep and in the last. It moves poses and
  /// never enters velocity. Overlaps beyond what is opened at this speed push no harder than that:
  /// with 1 m/s, which 7 mm reach, cubes at the bottom of a heap of 8000 sink into each other by
  /// 135 mm under the many smaller overlaps above; with 4 by 42.
  double push_speed = 4.0;
  /// m: carried multipliers are applied before the sweep where the gap is below this.
  double warm_start_gap = 1e-3;
  /// What a step may cost beyond the solver's substeps: rows that are solved once more. Islands
  /// that want more substeps come first: where the rows of all of them in all further substeps are
  /// more than this, each gets a share. What they leave, a sixth of it, is for rows that one
  /// sweep has not solved: they are swept on, those first whose bodies still move most, until no
  /// normal velocity changes by more than `resting_tolerance` times what gravity adds in a substep.
  /// A gap that closes no faster than that is none.
  /// What is left open rocks what stands: a tower of ten cubes of 10 cm, each a few millimetres off
  /// the one below, swayed by 2 mm for ever at 0.01, and walked by 3 cm in 30 s.
  /// Blows that pass from contact to contact may strike a sixth as well. BlockReport says what
  /// was done and what was left.
  int extra_rows = 24000;
  double resting_tolerance = 0.001;
  /// Impacts slower than this many times what gravity adds in a substep do not bounce. Here and
  /// above gravity is 1 m/s^2 at least: what floats comes to rest as well.
  double restitution_threshold = 2.0;
  /// Rows that are solved at once by vector instructions, 2 or 4; 0: as many as the processor can.
  /// The bits are the same.
  int lanes = 0;

  friend bool operator==(const ContactOptions&, const ContactOptions&) = default;
};

/// One manifold of a step and what is carried from step to step with it.
struct TANDEM_API Contact {
  Manifold manifold = {};
  std::array<double, 4> force{};       ///< N, normal, of the last substep; >= 0
  Vec3 friction_force = Vec3::Zero();  ///< N, world, on body b, of the last substep
  /// What friction the next step starts from, smoothed over steps: N, world, on body b, and N m
  /// about the normal.
  Vec3 carried_friction = Vec3::Zero();
  double carried_twist = 0.0;
  /// Of the force, that the next step starts from: less after impacts that are over.
  double warm_start_scale = 1.0;
  /// m/s, fastest approach that an impulse stopped in the last step; >= 0
  double approach_speed = 0.0;
  double impulse = 0.0;   ///< N s, normal, sum over points and substeps of the last step
  double overlap = -1.0;  ///< m, at the end of the last step, >= 0; below 0: not known yet

  /// All but which pair it is (key, order, bodies).
  void save(ByteWriter& out) const;
  /// The input is untrusted: fails `in` where no contact can have such values.
  void load(ByteReader& in);
  /// Whether any point carried a load in the last substep.
  bool loaded() const {
    return force[0] > 0.0 || force[1] > 0.0 || force[2] > 0.0 || force[3] > 0.0;
  }
};

/// What passes over all contacts ask of each: contacts are seven cache lines.
struct ContactBrief {
  std::uint32_t a = 0, b = 0;  ///< bodies
  bool face = false;           ///< more than one point
  bool loaded = false;         ///< see Contact::loaded()
  bool is_new = false;         ///< not there in the last step
  bool rubs = false;           ///< its friction is above 0
};

/// All contacts of a world, one for each manifold of the last detection, by ascending key; solved
/// in the order of their manifolds.
///
/// C_i = normal . (p_b,i - p_a,i) - radius_a - radius_b  [m];  C >= 0, lambda >= 0, C lambda = 0.
/// All normals of a manifold are solved together, as a linear complementarity problem of up to four
/// unknowns; friction acts at their centre of pressure, as a 2x2 block in the tangent plane and one
/// row of twist about the normal. Both are solved for the velocity of the substep: with Jacobians
/// that stand for a whole step, moving a pose by h dv and projecting C(x + h v) are the same thing,
/// and no orientation has to be renewed within a sweep. Gaps are measured from poses once for each
/// substep, from the anchors.
/// Friction: the displacement of the substep is undone, with |lambda_t| <= mu sum(lambda_i): the
/// multiplier is clamped to the cone, not skipped outside it. The velocity pass goes on with the
/// same multiplier, because stopping normal velocities makes a tilted body slide.
/// Source: [mueller2020] Sec. 3.5 and 3.6. Differs: as above, and warm start, velocity pass with
/// accumulated clamp.
class TANDEM_API ContactBlock final : public ConstraintBlock {
 public:
  ContactBlock();
  ~ContactBlock() override;

  /// Take this step's manifolds (any order; left empty) and carry forces over from the contact of
  /// the same pair, point by point: same feature, else nearest anchor.
  void set_manifolds(std::vector<Manifold>& manifolds, Workers& workers);
  /// Contacts that another block has solved until now: the next set_manifolds() carries on what it
  /// finds of them, as if they had been here. Those of pairs that are here already are left out.
  void adopt(std::span<const Contact> contacts);
  void configure(const ContactOptions& options);
  std::span<const Contact> contacts() const;
  /// Of the same contacts, in the same order.
  std::span<const ContactBrief> briefs() const;
  bool any_friction() const;     ///< some contact has a coefficient above 0
  bool any_restitution() const;  ///< likewise

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
  /// Bodies whose loaded contact is gone: a collider was removed or filtered, or what they lay on
  /// was moved away.
  void take_changed(std::vector<std::uint32_t>& bodies) override;
  /// What carries a load supports.
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
