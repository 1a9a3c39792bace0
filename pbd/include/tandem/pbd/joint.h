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

/// State of a joint after the last step; before the first step only its position when it was added.
struct TANDEM_API JointState {
  /// Coordinates of frame b in frame a: three displacements (m), then twist about x and the swing
  /// components about y and z (rad). Twist counts turns unless it is locked. Swing is the rotation
  /// vector that carries the x axis of a to that of b, so it ends at pi. If y or z alone is free,
  /// that axis takes x's part and counts turns.
  std::array<double, 6> position{};
  double swing = 0.0;            ///< rad, >= 0, angle between the x axes: what the cone limits
  std::array<double, 6> load{};  ///< N and N m, per coordinate, on body b
  /// N, world, on body b at its frame, last substep. In the step in which it breaks: the force of
  /// the substep that broke it.
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();  ///< N m, world, on body b, last substep
  double residual = 0.0;       ///< m (linear) or rad (angular), largest violation of a rigid row
  bool broken = false;  ///< disabled by break_force or break_torque; enable it to use it again
};

class JointBlock;

/// Ids of all joints of a block, by slot.
TANDEM_API std::vector<JointId> joint_ids(const JointBlock& block);

/// All rigid, limited, sprung and driven joints of a world as one kind: six coordinates, each with
/// a force law (joint_def.h). Joints that share bodies are solved together by a sparse block LDL^T
/// factorisation: a chain costs O(n) and converges at once; trees have no fill-in, loops little.
///
/// Rows use the gradients at the start of the substep, so that a converged step is a SHAKE step
/// [ryckaert1977]. Where the force of a taut joint would turn a body faster than the substep
/// resolves, a part of its geometric stiffness is added to the inertia: stable at any step, and
/// without effect on slow motion.
/// Violation that exists before a step (as added, or by set_pose) closes at 5 m/s and 10 rad/s at
/// most and leaves no velocity. A hinge takes the turn that lies within its limits.
/// @par Thread safety  As World. Rows of distinct groups may be solved at the same time.
class TANDEM_API JointBlock final : public ConstraintBlock {
 public:
  JointBlock();
  ~JointBlock() override;

  /// @throws std::invalid_argument naming the field, its value and the rule
  JointId add(const World& world, const SixDofJointDef& def);
  bool contains(JointId id) const;
  /// All methods below throw std::invalid_argument if the id names no joint.
  void remove(JointId id);
  /// Change parameters; carried state stays. The bodies may not change.
  void set(const World& world, JointId id, const SixDofJointDef& def);
  void set_enabled(JointId id, bool enabled);
  /// The returned references are valid until a joint is added, or the block is loaded or assigned
  /// to.
  const SixDofJointDef& def(JointId id) const;
  const JointState& at(JointId id) const;
  /// Angle of a hinge, rad, counting turns: as added, then after the last step. @throws for other
  /// joints, too
  double hinge_angle(JointId id) const;
  /// Position of a slider, m: as added, then after the last step. @throws for other joints, too
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
  /// Wants enough substeps that the bodies of a joint turn against each other by at most 0.07 rad
  /// in each, now and two steps on. Stiffness of taut chains needs no more; only fast folding does.
  void end_step(const SubstepContext& ctx, std::span<double> wanted) override;
  void take_changed(std::vector<std::uint32_t>& bodies) override;
  /// Motors that have arrived, are at a limit or cannot move their load are not actuated.
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
