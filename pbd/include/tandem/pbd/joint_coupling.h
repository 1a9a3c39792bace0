// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "tandem/pbd/joint.h"
#include "tandem/pbd/joint_gap.h"
#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {

/// Holds the coordinates of two joints in proportion, like gears, racks and tendons of fingers:
/// C = c_two - ratio c_one - offset [rad or m]. Each joint is a hinge or a slider.
///
/// Solved after the joints, together with their rows, so that the hinges stay closed. Bodies
/// attached beyond the two joints are not part of the solve: with heavy ones it loses energy.
class TANDEM_API JointCoupling {
 public:
  static constexpr std::string_view kName = "joint_coupling";
  static constexpr int kOrder = static_cast<int>(SolveOrder::Joint) + 1;
  static constexpr bool kGroupsAtOnce = true;

  /// The bodies and frames of a joint, and its free coordinate.
  struct TANDEM_API Side {
    BodyId a = {};  ///< the invalid id stands for the world
    BodyId b = {};
    JointFrame frame_a = {}, frame_b = {};
    bool slides = false;  ///< along x, m; else it turns about x, rad
    double start = 0.0;   ///< rad, position when the row is added: selects the turn

    /// Index into JointState::position.
    int coordinate() const { return slides ? 0 : 3; }
  };
  struct TANDEM_API Def {
    Side one = {}, two = {};
    double ratio = 1.0;
    double offset = 0.0;  ///< rad or m
    bool enabled = true;
  };

  /// Couples two joints as they are; if one of them is removed, remove the coupling too.
  /// @throws std::invalid_argument  if one of them is neither a hinge nor a slider
  static Def between(const JointBlock& joints, JointId one, JointId two, double ratio,
                     double offset = 0.0);
  static void check(const World& world, const Def& def);
  explicit JointCoupling(const Def& def) : def_(def), near_{def.one.start, def.two.start} {}

  const Def& def() const { return def_; }
  Def& def() { return def_; }
  BodyId body_a() const { return def_.one.b; }
  BodyId body_b() const { return def_.two.b; }
  bool active() const { return def_.enabled; }
  /// Whether the row reads or moves the body.
  bool names(BodyId body) const;
  /// Appends edges to the other bodies of the joints.
  void append_edges(std::vector<ConstraintEdge>& edges) const;
  double residual() const { return residual_; }  ///< rad or m
  double displacement_residual() const { return displacement_residual_; }

  void forgive(const SubstepContext& ctx);
  bool find_gap(const SubstepContext& ctx);
  void begin_substep(const SubstepContext& ctx);
  double project(const SubstepContext& ctx);
  void begin_displacement(const SubstepContext& ctx);
  double project_displacement(const SubstepContext& ctx);
  void end_displacement(const SubstepContext& ctx);
  void end_step(const SubstepContext& ctx);
  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  double violated(const SubstepContext& ctx);
  double solve(const SubstepContext& ctx, double target);

  Def def_;
  std::array<double, 2> near_;          ///< rad, last angles of hinges, counting turns
  double displacement_residual_ = 0.0;  ///< left by agreement
  double bound_ = 0.0;                  ///< value at which the displacement channel holds C
  double residual_ = 0.0;
  JointGap gap_;
};

using JointCouplingBlock = TypedBlock<JointCoupling>;

}  // namespace tandem::pbd
