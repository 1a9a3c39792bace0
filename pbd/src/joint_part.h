// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "joint_algebra.h"
#include "joint_graph.h"
#include "joint_record.h"

/// Plain data of the joint projection: nodes (joints), slots (bodies), the values of the linear
/// system, and one part of the joint graph within a substep.
namespace tandem::pbd {

enum class JointChannel { Real, Displacement };

/// Data of every node.
struct JointNode {
  int n = 0;
  bool off = false;  ///< broken in this step
  /// Multipliers are from the last substep. Those at corners of their laws stay there, as poses
  /// predicted by those forces alone say little about the rest.
  bool warm = false;
  Vec3 r_a = Vec3::Zero(), r_b = Vec3::Zero();  ///< m, world
  double pull_a = 0.0,
         pull_b = 0.0;  ///< N m s^2, pull of the ends away from the centres
  std::array<double, kCoordinates> lambda{}, at{};
  std::array<double, kCoordinates> lambda_start{};  ///< at the start of the position iteration
  Mat3 b_a = Mat3::Zero(), b_b = Mat3::Zero();      ///< parts of points: inverse inertia times arm
  Vec3 target = Vec3::Zero();                       ///< m, parts of points
  double softness = 0.0;                            ///< parts of points; compliance / h^2

  /// Adds the pull of an impulse, N s^2, on body b to the ends.
  void add_pull(const JointGraph::Node& plan, const Vec3& impulse) {
    if (plan.slot_a != JointGraph::kNone) pull_a = std::max(pull_a, -r_a.dot(impulse));
    if (plan.slot_b != JointGraph::kNone) pull_b = std::max(pull_b, r_b.dot(impulse));
  }
};

/// Further data of a node, unless all of its part are points.
/// Column k belongs to coordinate k: dC/dt = dir (v_b - v_a) + arm_b w_b - arm_a w_a.
struct JointRows {
  using Columns = Eigen::Matrix<double, 3, kCoordinates>;

  std::array<std::uint8_t, kCoordinates> coordinate{};
  std::array<Segment, kCoordinates> segment{};  ///< by row
  std::array<double, kCoordinates> left{};      ///< by row, residual to solve
  std::array<double, kCoordinates> newton{};    ///< by row, the step that solves it
  std::array<bool, kCoordinates> pinned{};      ///< by row: the step ends at the end of its piece
  std::uint32_t stops = 0;                      ///< bits of coordinates at a limit
  std::array<double, kCoordinates> w{};
  Columns arm_a = Columns::Zero(), arm_b = Columns::Zero();  ///< m, and 1 for angles
  Columns b_a = Columns::Zero(), b_b = Columns::Zero();      ///< inverse inertia times arm
  Columns dir = Columns::Zero();
  std::array<ForceLaw, kCoordinates> law;
  std::array<double, kCoordinates> start{};  ///< coordinates at the substep's start
};

/// In body axes, kg m^2.
struct LocalInertia {
  Mat3 inertia = Mat3::Zero();
  Mat3 inverse = Mat3::Zero();
  PrincipalAxes principal;
};

struct JointSlotMotion {
  Vec3 v = Vec3::Zero();         ///< m/s
  Vec3 momentum = Vec3::Zero();  ///< N m s
};

struct JointSlotMove {
  Vec3 dx = Vec3::Zero();      ///< m
  Vec3 dtheta = Vec3::Zero();  ///< rad
};

/// State of a body at the start of a position iteration.
struct JointSlotPlace {
  Vec3 x = Vec3::Zero();  ///< m, predicted
  Quat q = Quat::Identity();
  JointSlotMove move;  ///< the body's corrections so far
};

/// A body of a part.
struct JointSlot {
  double inv_mass = 0.0;
  Mat3 inv_inertia = Mat3::Zero();  ///< including stiffen()
  Mat3 inertia = Mat3::Zero();      ///< kg m^2, without stiffen(); real channel only
  Mat3 inv_own = Mat3::Zero();      ///< inverse of inertia
  Mat3 stiffness = Mat3::Zero();    ///< see stiffen()
  Vec3 dx = Vec3::Zero();
  Vec3 dtheta = Vec3::Zero();
  JointSlotMove sum;      ///< in this position iteration
  Vec3 v = Vec3::Zero();  ///< m/s and rad/s, predicted
  Vec3 w = Vec3::Zero();
  JointSlotMotion start;            ///< before gravity and other forces; loops only
  Quat q_start = Quat::Identity();  ///< at the start of the substep
  JointSlotPlace before;
  bool alone = false;  ///< no other rows have turned it before, and no axis is locked
  LocalInertia local;  ///< at the start of the step; 0: not computed yet
  JointSlotMove seen;  ///< the body's corrections when its part converged
  // As of the plan:
  bool turns_freely = false;
  bool primary = false;  ///< first slot of its body
};

/// Progress of solving a part in a substep.
struct JointProgress {
  /// Compliance of redundant rows of loops, relative to their own mobility, by which they share
  /// their load. A rope of 50 links held at both ends sags by less than 1e-6 m from it. With less,
  /// rounding and second-order terms of turns become loads: at 1e-9 a lattice of 4 x 4 bodies flies
  /// apart.
  static constexpr double kRedundancy = 1e-6;

  bool prepared = false;
  bool holds = false;  ///< no body has to move by more than the tolerance
  bool factored = false;
  bool changed = false;      ///< the last iteration used other rows than the one before
  bool pinned = false;       ///< in it rows have reached a corner of their law
  bool left_pieces = false;  ///< its moves brought rows to other pieces of their laws
  int iteration = 0;
  bool restarted = false;
  int softened = 0;     ///< number of times; see adds_energy()
  bool linear = false;  ///< limits and motors use coordinates linearised by their gradients
  double redundancy = kRedundancy;
  double last_move = 0.0;
  JointChannel channel = JointChannel::Real;
  bool closing = false;  ///< displacement: one of its joints closes a gap, see JointGap
  int position_iteration = 0;
  double work = 0.0;  ///< J, by the previous position iterations
};

/// Data of all parts. Scratch memory, except for the graph.
struct JointData {
  JointGraph graph;
  std::vector<JointNode> nodes;
  std::vector<JointRows> rows;  ///< empty if all parts are points
  std::vector<JointSlot> slots;
  std::vector<double> values;  ///< blocks of the matrix, then of its factors
  std::vector<double> right;   ///< right-hand sides, then solutions
};

/// One part of the graph in one substep.
struct JointPart {
  JointData& all;
  const JointGraph::Part& plan;
  JointProgress& progress;
  bool passive;  ///< rigid locks, limits and brakes only
  std::span<JointRecord> records;
  const SubstepContext& ctx;

  /// Calls visit(k, plan, node) for each of its nodes, in the order of elimination.
  void for_nodes(auto&& visit) const {
    for (std::uint32_t k = plan.node; k < plan.node + plan.node_count; ++k) {
      visit(k, all.graph.nodes()[k], all.nodes[k]);
    }
  }
  /// The same for its joints, without hubs and broken ones.
  void for_joints(auto&& visit) const {
    for_nodes([&](std::uint32_t k, const JointGraph::Node& node_plan, JointNode& node) {
      if (node_plan.joint != JointGraph::kNone && !node.off) visit(k, node_plan, node);
    });
  }
  /// Calls visit(slot, body) for each of its bodies.
  void for_bodies(auto&& visit) const {
    for (std::uint32_t s = plan.body; s < plan.body + plan.body_count; ++s) {
      visit(all.slots[s], ctx.bodies[all.graph.bodies()[s]]);
    }
  }
  /// N s^2, on body b of a node, since the start of the substep.
  Vec3 impulse(std::uint32_t k, std::uint32_t used) const {
    const JointNode& node = all.nodes[k];
    if (plan.points) return Vec3(node.lambda[0], node.lambda[1], node.lambda[2]);
    Vec3 sum = Vec3::Zero();
    for_bits(used & 7u, [&](int i) { sum += node.lambda[i] * all.rows[k].dir.col(i); });
    return sum;
  }
};

}  // namespace tandem::pbd
