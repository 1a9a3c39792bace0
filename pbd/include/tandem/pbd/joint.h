// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "tandem/pbd/export.h"
#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {

using JointId = ConstraintId;

/// What a joint did in the last step; before the first one its position alone, as it was added.
struct TANDEM_API JointState {
  /// Coordinates of frame b in frame a: three displacements (m), then twist about x and the swing
  /// components about y and z (rad). Twist counts turns unless it is locked; swing is the rotation
  /// vector that carries the x axis of a to that of b, so it ends at pi. Where y or z is free alone
  /// that axis has x's part: it counts turns.
  std::array<double, 6> position{};
  double swing = 0.0;            ///< rad, >= 0, angle between the x axes: what the cone limits
  std::array<double, 6> load{};  ///< N and N m, of each coordinate, on body b
  /// N, world, on body b at its frame, last substep; in the step in which it breaks that of the
  /// substep that broke it.
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();  ///< N m, world, on body b, last substep
  double residual = 0.0;       ///< m (linear) or rad (angular), largest violation of a rigid row
  bool broken = false;         ///< by break_force or break_torque; enable it to use it again
};

class JointBlock;

/// All joints of a block, by slot.
TANDEM_API std::vector<JointId> joint_ids(const JointBlock& block);

/// All rigid, limited, sprung and driven joints of a world as one kind: six coordinates, each with
/// a force law (joint_def.h). Joints that share bodies are solved together by a sparse block LDL^T
/// factorisation, so that a chain costs O(n) and holds at once; trees have no fill-in, loops
/// little.
///
/// Rows use the gradients of the substep's start, which makes a converged step that of SHAKE
/// [ryckaert1977]. Taut joints whose own force would turn a body faster than the substep resolves
/// add a part of their geometric stiffness to its inertia: stable at any step, and without effect
/// on slow motion.
/// A joint that is violated before a step, as it was added or its bodies were put like that, comes
/// back at 5 m/s and 10 rad/s at most and leaves no velocity. A hinge takes the turn that lies
/// within its limits.
/// @par Thread safety  As World. Rows of distinct groups may be solved at the same time.
class TANDEM_API JointBlock final : public ConstraintBlock {
 public:
  JointBlock();
  ~JointBlock() override;

  /// @throws std::invalid_argument naming the field, its value and the rule
  JointId add(const World& world, const SixDofJointDef& def);
  bool contains(JointId id) const;
  /// All of these throw std::invalid_argument where the id names no joint.
  void remove(JointId id);
  /// Change parameters; carried state stays. The bodies may not change.
  void set(const World& world, JointId id, const SixDofJointDef& def);
  void set_enabled(JointId id, bool enabled);
  /// References to both are good until a joint is added, or the block loaded or assigned to.
  const SixDofJointDef& def(JointId id) const;
  const JointState& at(JointId id) const;
  /// rad, of a hinge, as it was added, then after the last step; counts turns. @throws for other
  /// joints, too
  double hinge_angle(JointId id) const;
  /// m, of a slider, likewise. @throws for other joints, too
  double slider_position(JointId id) const;
  int size() const;

  std::string_view name() const override { return "joint"; }
  int order() const override { return static_cast<int>(SolveOrder::Joint); }
  bool empty() const override;
  bool groups_at_once() const override { return true; }
  bool has_gaps() const override;
  void begin_step(const SubstepContext& ctx) override;
  void begin_substep(const SubstepContext& ctx) override;
  double project(const SubstepContext& ctx) override;
  void finish_projection(const SubstepContext& ctx) override;
  void finish_velocity(const SubstepContext& ctx) override;
  void begin_displacement(const SubstepContext& ctx) override;
  double project_displacement(const SubstepContext& ctx) override;
  void end_displacement(const SubstepContext& ctx) override;
  /// Wants as many substeps as keep the bodies of a joint from turning by more than 0.07 rad
  /// against each other in one, now or two steps on. Taut chains need no more for their stiffness;
  /// only fast folding does.
  void end_step(const SubstepContext& ctx, std::span<double> wanted) override;
  void take_changed(std::vector<std::uint32_t>& bodies) override;
  /// Not actuated: motors that have arrived, that a limit stops or that do not manage their load.
  void append_edges(std::vector<ConstraintEdge>& edges) const override;
  void append_idle(std::vector<ConstraintEdge>& edges) const override;
  void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const override;
  void append_apart(std::vector<BodyPair>& pairs) const override;
  void remove_body(BodyId body) override;
  BlockReport report() const override;
  void save(ByteWriter& out) const override;
  void load(ByteReader& in) override;
  bool fits(const World& world) const override;
  std::unique_ptr<ConstraintBlock> make_empty() const override;
  bool assign(const ConstraintBlock& source) override;

 private:
  friend std::vector<JointId> joint_ids(const JointBlock& block);

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::pbd
