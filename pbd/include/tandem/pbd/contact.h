// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <vector>

#include "tandem/pbd/constraint.h"
#include "tandem/pbd/manifold.h"

namespace tandem::pbd {

/// How contacts are solved; part of SolverOptions.
struct ContactOptions {
  /// m/s: bodies that overlap when the step starts are pushed apart no faster than this.
  double push_speed = 1.0;
  /// m: carried multipliers are applied before the sweep where the gap is below this.
  double warm_start_gap = 1e-3;
  /// Compliance of the normals relative to their own mobility: a loaded point sinks in by
  /// softness * w * lambda, 3 micrometres for a body at rest at 10 substeps. It settles how the
  /// four points of a face share a load, which rigid rows leave open; without it the shares wander
  /// until one point lets go, and a stack of ten rocks itself over.
  double softness = 0.1;
  /// m: the clean-up leaves this much overlap alone, so that resting contacts stay loaded.
  double clean_up_slop = 5e-3;
  /// Impacts slower than this many times |gravity| * h do not bounce.
  double restitution_threshold = 2.0;
};

/// One manifold with its multipliers. All normals of a manifold are solved together, as a linear
/// complementarity problem of up to four unknowns; friction acts at their centre of pressure, as a
/// 2x2 block in the tangent plane and one row of twist about the normal.
/// C_i = normal . (p_b,i - p_a,i) - radius_a - radius_b  [m];  C >= 0, lambda >= 0, C lambda = 0.
/// Friction: the tangential displacement within the substep is undone, with |lambda_t| <= mu
/// sum(lambda_i): the multiplier is clamped to the cone, not skipped outside it. The velocity pass
/// goes on with the same multiplier, because stopping normal velocities makes a tilted body slide.
/// Source: [mueller2020] Sec. 3.5 and 3.6. Differs: block solve, warm start, one friction block for
/// each manifold, C from anchors of the step's start, velocity pass with accumulated clamp.
struct ContactRow {
  Manifold manifold;
  std::array<double, 4> lambda{};   ///< N s^2, carried from substep to substep and step to step
  std::array<double, 4> gap{};      ///< m, <= 0: the overlap that agreement left behind
  std::array<double, 4> bound{};    ///< m, <= 0: how far the total channel may close the gap
  std::array<double, 4> total{};    ///< multipliers of the total channel
  std::array<double, 4> overlap{};  ///< m, >= 0: overlap at the start of the substep
  std::array<double, 4> speed{};    ///< m/s, normal velocity before integration
  std::array<double, 4> impulse{};  ///< N s, of the velocity pass, >= -lambda / h
  std::array<Vec3, 4> arm_a;        ///< m, world, centre of mass to the common contact point
  std::array<Vec3, 4> arm_b;
  std::array<std::array<double, 4>, 4> mobility{};  ///< 1/kg, J M^-1 J^T of the normals
  Vec3 tangent_1, tangent_2;
  Vec3 centre_a, centre_b;  ///< m, world, lever arms of the centre of pressure
  Eigen::Matrix<double, 2, 2, Eigen::DontAlign> slide_mass;  ///< kg, in the tangents
  double twist_mass = 0.0;                                   ///< kg m^2; 0 for a single point
  bool grips = false;                                        ///< loaded in this substep
  Eigen::Matrix<double, 2, 1, Eigen::DontAlign> friction =
      Eigen::Matrix<double, 2, 1, Eigen::DontAlign>::Zero();  ///< N s^2, both passes
  double twist = 0.0;                                         ///< N m s^2, both passes
};

/// All contacts of a world. Rows follow the manifolds of the last detection, by ascending key.
class ContactBlock final : public ConstraintBlock {
 public:
  /// Take this step's manifolds (sorted by key; left empty of use afterwards) and carry multipliers
  /// over from the rows of the same pair, point by point: same feature, else nearest anchor.
  /// @param h_ratio  new substep / old substep, to rescale multipliers
  void set_manifolds(std::vector<Manifold>& manifolds, double h_ratio);
  void configure(const ContactOptions& options, double gravity_norm);
  const std::vector<ContactRow>& rows() const { return rows_; }

  std::string_view name() const override { return "contact"; }
  int order() const override { return static_cast<int>(SolveOrder::Contact); }
  bool empty() const override { return rows_.empty(); }
  void begin_substep(const SubstepContext& ctx) override;
  void warm_start(const SubstepContext& ctx) override;
  double project(const SubstepContext& ctx) override;
  double solve_velocity(const SubstepContext& ctx) override;
  void begin_total(const SubstepContext& ctx) override;
  void project_total(const SubstepContext& ctx) override;
  void end_total(const SubstepContext& ctx) override;
  void clean_up(const SubstepContext& ctx) override;
  void end_step(const SubstepContext& ctx) override;
  void links(LinkVisitor& visitor) const override;
  void remove_body(BodyId body) override;
  BlockReport report() const override;
  void save(ByteWriter& out) const override;
  void load(ByteReader& in) override;

 private:
  std::vector<ContactRow> rows_;
  std::vector<ContactRow> previous_;  ///< last step's rows, kept for their capacity
  ContactOptions options_;
  double bounce_acceleration_ = 0.0;  ///< m/s^2
  double residual_ = 0.0;
  double total_residual_ = 0.0;
};

}  // namespace tandem::pbd
