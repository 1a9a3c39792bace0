// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "joint_algebra.h"
#include "joint_graph.h"
#include "joint_record.h"

/// What projecting joints works on, as plain data: nodes (joints), slots (bodies) and the values of
/// the linear system, and one part of the joint graph within a substep.
namespace tandem::pbd {

enum class JointChannel { Real, Displacement };

/// What every node has.
struct JointNode {
  int n = 0;
  bool off = false;  ///< broken in this step
  /// Multipliers are those of the last substep: those at corners of their laws stay there, as where
  /// its forces alone bring the bodies says little of the way on.
  bool warm = false;
  Vec3 r_a = Vec3::Zero(), r_b = Vec3::Zero();  ///< m, world
  double pull_a = 0.0,
         pull_b = 0.0;  ///< N m s^2, how much the ends are pulled away from the centres
  std::array<double, kCoordinates> lambda{}, at{};
  std::array<double, kCoordinates> lambda_start{};  ///< of the position iteration
  Mat3 b_a = Mat3::Zero(), b_b = Mat3::Zero();      ///< parts of points: inverse inertia times arm
  Vec3 target = Vec3::Zero();                       ///< m, likewise
  double softness = 0.0;                            ///< likewise; compliance / h^2

  /// The ends are pulled by an impulse, N s^2, on body b.
  void add_pull(const JointGraph::Node& plan, const Vec3& impulse) {
    if (plan.slot_a != JointGraph::kNone) pull_a = std::max(pull_a, -r_a.dot(impulse));
    if (plan.slot_b != JointGraph::kNone) pull_b = std::max(pull_b, r_b.dot(impulse));
  }
};

/// What a node has as well where not all of its part are points.
/// Column k belongs to coordinate k: dC/dt = dir (v_b - v_a) + arm_b w_b - arm_a w_a.
struct JointRows {
  using Columns = Eigen::Matrix<double, 3, kCoordinates>;

  std::array<std::uint8_t, kCoordinates> coordinate{};
  std::array<Segment, kCoordinates> segment{};  ///< by row
  std::array<double, kCoordinates> left{};      ///< by row, what is to be solved
  std::array<double, kCoordinates> newton{};    ///< by row, the step that solves it
  std::array<bool, kCoordinates> pinned{};      ///< by row: the step ends where its piece does
  std::uint32_t stops = 0;                      ///< bit per coordinate that is at a limit
  std::array<double, kCoordinates> w{};
  Columns arm_a = Columns::Zero(), arm_b = Columns::Zero();  ///< m, and 1 for angles
  Columns b_a = Columns::Zero(), b_b = Columns::Zero();      ///< inverse inertia times arm
  Columns dir = Columns::Zero();
  std::array<ForceLaw, kCoordinates> law;
  std::array<double, kCoordinates> start{};  ///< coordinates at the substep's start
};

/// About the axes of the body, kg m^2.
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

/// Where a position iteration finds a body.
struct JointSlotPlace {
  Vec3 x = Vec3::Zero();  ///< m, predicted
  Quat q = Quat::Identity();
  JointSlotMove move;  ///< the body's corrections so far
};

/// A body of a part.
struct JointSlot {
  double inv_mass = 0.0;
  Mat3 inv_inertia = Mat3::Zero();  ///< with what stiffen() adds
  Mat3 inertia = Mat3::Zero();      ///< kg m^2, the body's own; real channel only
  Mat3 inv_own = Mat3::Zero();      ///< its inverse
  Mat3 stiffness = Mat3::Zero();    ///< see stiffen()
  Vec3 dx = Vec3::Zero();
  Vec3 dtheta = Vec3::Zero();
  JointSlotMove sum;      ///< of this position iteration
  Vec3 v = Vec3::Zero();  ///< m/s and rad/s, predicted
  Vec3 w = Vec3::Zero();
  JointSlotMotion start;            ///< before gravity and other forces; loops only
  Quat q_start = Quat::Identity();  ///< at the start of the substep
  JointSlotPlace before;
  bool alone = false;    ///< no other rows have turned it before
  bool carried = false;  ///< what turns it is an impulse at the substep's start
  LocalInertia local;    ///< as the step began; 0: not asked for yet
  JointSlotMove seen;    ///< the body's corrections when its part held
  // As the plan was made:
  bool turns_freely = false;
  bool primary = false;  ///< the first one of its body
};

/// How far the solve of a part has come in a substep.
struct JointProgress {
  /// Rows of loops may repeat each other: they share their load as if they had this much
  /// compliance, relative to their own mobility. A rope of 50 links held at both ends sags by less
  /// than 1e-6 m from it. Less of it lets rounding and the squares of turns become loads of their
  /// own: at 1e-9 a lattice of 4 x 4 bodies flies apart.
  static constexpr double kRedundancy = 1e-6;

  bool prepared = false;
  bool holds = false;  ///< nothing has to move by more than the tolerance
  bool factored = false;
  bool changed = false;      ///< the last iteration had other rows than the one before
  bool pinned = false;       ///< rows have come to a corner of their law in it
  bool left_pieces = false;  ///< its moves brought rows to other pieces of theirs
  int iteration = 0;
  bool restarted = false;
  int softened = 0;     ///< how often; see adds_energy()
  bool linear = false;  ///< limits and motors see coordinates as their gradients have them
  double redundancy = kRedundancy;
  double last_move = 0.0;
  JointChannel channel = JointChannel::Real;
  bool closing = false;  ///< displacement: one of its joints has a gap, see JointGap
  int position_iteration = 0;
  double work = 0.0;  ///< J, of the position iterations before it
};

/// Of all parts. Scratch memory, but for the graph.
struct JointData {
  JointGraph graph;
  std::vector<JointNode> nodes;
  std::vector<JointRows> rows;  ///< empty where all parts are points
  std::vector<JointSlot> slots;
  std::vector<double> values;  ///< blocks of the matrix, later of its factors
  std::vector<double> right;   ///< right-hand sides, later solutions
};

/// One part of the graph in one substep.
struct JointPart {
  JointData& all;
  const JointGraph::Part& plan;
  JointProgress& progress;
  bool passive;  ///< rigid locks, limits and brakes only
  std::span<JointRecord> records;
  const SubstepContext& ctx;

  /// visit(k, plan, node) for each of its nodes, in the order of elimination.
  void for_nodes(auto&& visit) const {
    for (std::uint32_t k = plan.node; k < plan.node + plan.node_count; ++k) {
      visit(k, all.graph.nodes()[k], all.nodes[k]);
    }
  }
  /// The same for its joints: neither hubs nor what is broken.
  void for_joints(auto&& visit) const {
    for_nodes([&](std::uint32_t k, const JointGraph::Node& node_plan, JointNode& node) {
      if (node_plan.joint != JointGraph::kNone && !node.off) visit(k, node_plan, node);
    });
  }
  /// visit(slot, body) for each of its bodies.
  void for_bodies(auto&& visit) const {
    for (std::uint32_t s = plan.body; s < plan.body + plan.body_count; ++s) {
      visit(all.slots[s], ctx.bodies[all.graph.bodies()[s]]);
    }
  }
  /// N s^2, on body b of a node, since the substep began.
  Vec3 impulse(std::uint32_t k, std::uint32_t used) const {
    const JointNode& node = all.nodes[k];
    if (plan.points) return Vec3(node.lambda[0], node.lambda[1], node.lambda[2]);
    Vec3 sum = Vec3::Zero();
    for_bits(used & 7u, [&](int i) { sum += node.lambda[i] * all.rows[k].dir.col(i); });
    return sum;
  }
};

}  // namespace tandem::pbd
