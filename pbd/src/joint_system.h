// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <vector>

#include "joint_algebra.h"
#include "joint_graph.h"
#include "joint_record.h"

namespace tandem::pbd {

/// The rows of all joints as one sparse system for each part of the joint graph: what is needed to
/// project them together. Scratch memory only.
class JointSystem {
 public:
  enum class Channel { Real, Displacement };

  /// Plan for the joints that are active; allocates. Where bodies have an order of their own,
  /// joints are taken by the order of their bodies, else by slot.
  void build(std::span<const JointRecord> records, std::span<const SolverBody> bodies,
             const BodyOrder& order);
  /// Whether the plan still fits which bodies can move.
  bool fits(std::span<const JointRecord> records, std::span<const SolverBody> bodies) const;
  /// Sort parts by group for for_parts().
  void sort_groups(std::span<const SolverBody> bodies);

  template <class Visit>
  void for_parts(std::uint32_t group, bool reverse, Visit&& visit) {
    const auto before = [](const GroupPart& part, std::uint32_t g) { return part.group < g; };
    const auto first = std::lower_bound(order_.begin(), order_.end(), group, before);
    const auto last = std::find_if(first, order_.end(),
                                   [&](const GroupPart& part) { return part.group != group; });
    const std::ptrdiff_t count = last - first;
    for (std::ptrdiff_t k = 0; k < count; ++k) visit(first[reverse ? count - 1 - k : k].part);
  }
  std::uint32_t part_count() const { return static_cast<std::uint32_t>(graph_.parts().size()); }
  bool is_shared(std::uint32_t part, std::span<const SolverBody> bodies) const;

  /// Take gradients and force laws from the poses as they are; multipliers start at 0.
  void begin(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx,
             Channel channel);
  /// One Newton iteration. Returns how far the bodies may still be from where they belong, m.
  double iterate(std::uint32_t part, std::span<const JointRecord> records,
                 const SubstepContext& ctx);
  /// Forces of the substep into the records; joints that they are too much for break.
  void finish(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx);

 private:
  static constexpr std::uint32_t kNone = JointGraph::kNone;
  /// Rows of loops may repeat each other: they share their load as if they had this much
  /// compliance, relative to their own mobility. A rope of 50 links held at both ends sags by less
  /// than 1e-6 m from it. Less of it lets rounding and the squares of turns become loads of their
  /// own: at 1e-9 a lattice of 4 x 4 bodies flies apart.
  static constexpr double kRedundancy = 1e-6;
  using Rows = Eigen::Matrix<double, 3, kCoordinates>;
  /// What every node has.
  struct NodeState {
    int n = 0;
    bool off = false;                             ///< broken in this step
    Vec3 r_a = Vec3::Zero(), r_b = Vec3::Zero();  ///< m, world
    double pull_a = 0.0,
           pull_b = 0.0;  ///< N m s^2, how much the ends are pulled away from the centres
    std::array<double, kCoordinates> lambda{}, at{};
    std::array<double, kCoordinates> lambda_start{};  ///< of the position iteration
    Mat3 b_a = Mat3::Zero(), b_b = Mat3::Zero();  ///< parts of points: inverse inertia times arm
    Vec3 target = Vec3::Zero();                   ///< m, likewise
    double softness = 0.0;                        ///< likewise; compliance / h^2
  };
  /// What a node has as well where not all of its part are points.
  /// Column k belongs to coordinate k: dC/dt = dir (v_b - v_a) + arm_b w_b - arm_a w_a.
  struct NodeRows {
    std::array<std::uint8_t, kCoordinates> coordinate{};
    std::array<Segment::Kind, kCoordinates> kind{};
    std::array<Segment::Kind, kCoordinates> last_kind{};  ///< by coordinate
    std::array<std::uint8_t, kCoordinates> flips{};       ///< by coordinate, within this substep
    std::array<double, kCoordinates> w{};
    Rows arm_a = Rows::Zero(), arm_b = Rows::Zero();  ///< m, and 1 for angles
    Rows b_a = Rows::Zero(), b_b = Rows::Zero();      ///< inverse inertia times arm
    Rows dir = Rows::Zero();
    std::array<ForceLaw, kCoordinates> law;
  };
  struct Slot {
    double inv_mass = 0.0;
    Mat3 inv_inertia = Mat3::Zero();  ///< with what stiffen() adds
    Mat3 inertia = Mat3::Zero();      ///< kg m^2, the body's own; real channel only
    Mat3 inv_own = Mat3::Zero();      ///< its inverse
    Mat3 stiffness = Mat3::Zero();    ///< see stiffen()
    Vec3 dx = Vec3::Zero();
    Vec3 dtheta = Vec3::Zero();
    // Of this position iteration:
    Vec3 sum_dx = Vec3::Zero();
    Vec3 sum_dtheta = Vec3::Zero();
    Vec3 v = Vec3::Zero();  ///< m/s and rad/s, predicted
    Vec3 w = Vec3::Zero();
    Vec3 v_start = Vec3::Zero();         ///< m/s, before gravity and other forces; loops only
    Vec3 momentum_start = Vec3::Zero();  ///< N m s, likewise
    Quat q_start = Quat::Identity();     ///< at the start of the substep
    Quat q = Quat::Identity();           ///< predicted
    bool alone = false;                  ///< no other rows have turned it from there
    bool carried = false;                ///< see turn()
  };
  struct PartState {
    bool prepared = false;
    bool factored = false;
    bool changed = false;  ///< the last iteration had other rows than the one before
    int iteration = 0;
    bool restarted = false;
    int softened = 0;  ///< how often; see adds_energy()
    double redundancy = kRedundancy;
    double last_move = 0.0;
    Channel channel = Channel::Real;
    int position_iteration = 0;
    double work = 0.0;  ///< J, of the position iterations before it
  };
  /// Of a part in a substep, J.
  struct Balance {
    double work = 0.0;       ///< of joints
    double energy = 0.0;     ///< before, against the mean motion
    double disturbed = 0.0;  ///< of what others changed since joints were solved
  };
  struct GroupPart {
    std::uint32_t group, part;
  };

  void begin_points(const JointGraph::Part& part, std::span<JointRecord> records,
                    const SubstepContext& ctx, Channel channel);
  void begin_rows(const JointGraph::Part& part, std::span<JointRecord> records,
                  const SubstepContext& ctx, Channel channel);
  void resync_leapfrog(const JointGraph::Part& part, std::span<JointRecord> records,
                       const SubstepContext& ctx);
  static void turn(SolverBody& body, Slot& slot, double h);
  void prepare(const JointGraph::Part& part, PartState& state, std::span<const JointRecord> records,
               const SubstepContext& ctx);
  /// Contacts have been solved since: what follows is counted, and started anew, from here.
  void begin_iteration(const JointGraph::Part& part, PartState& state, const SubstepContext& ctx);
  void start_slots(const JointGraph::Part& part, const PartState& state, const SubstepContext& ctx);
  void turn_gradients(const JointGraph::Part& part, std::span<const JointRecord> records,
                      const SubstepContext& ctx);
  double newton(const JointGraph::Part& part, PartState& state,
                std::span<const JointRecord> records, const SubstepContext& ctx);
  void evaluate_points(const JointGraph::Part& part, std::span<const JointRecord> records,
                       const SubstepContext& ctx);
  /// @return whether other rows than before have a part in it
  bool evaluate(const JointGraph::Part& part, const PartState& state,
                std::span<const JointRecord> records, const SubstepContext& ctx);
  void assemble_points(const JointGraph::Part& part, const PartState& state);
  void assemble(const JointGraph::Part& part);
  static void put_hub(const Slot& slot, double* diagonal);
  void put_diagonal(std::uint32_t node);
  void couple_to_hub(const JointGraph::Link& link, bool hub_later);
  void couple_joints(const JointGraph::Link& link);
  void factor(const JointGraph::Part& part);
  void solve(const JointGraph::Part& part);
  template <class Size>
  void factor(const JointGraph::Part& part, Size&& size);
  template <class Size>
  void solve(const JointGraph::Part& part, Size&& size);
  /// Multipliers grow by the solution, and bodies are to move by it.
  void gather_points(const JointGraph::Part& part);
  void gather(const JointGraph::Part& part);
  /// Scale what gather() left to what one iteration may turn a body by.
  void limit_turns(const JointGraph::Part& part);
  /// @return the largest move of a body, m or rad
  double move(const JointGraph::Part& part, const SubstepContext& ctx);
  /// Of this position iteration.
  Balance balance(const JointGraph::Part& part, const SubstepContext& ctx, const Vec3& mean) const;
  /// @param work  J, of the position iterations before the last one
  void limit_energy_gain(const JointGraph::Part& part, double work, std::span<JointRecord> records,
                         const SubstepContext& ctx);
  static void take_gradients(NodeState& node, NodeRows& rows, const JointRecord& record,
                             const SolverBody& a, const SolverBody& b);
  /// Inverse inertia times gradients, and the mobility of each row by itself.
  void weigh(const JointGraph::Part& part, std::span<const JointRecord> records);
  static void apply_stiffness(Slot& slot, SolverBody& body);
  void stiffen(const JointGraph::Part& part, const SubstepContext& ctx);
  /// @param learn  whether the multipliers so far are the load that bodies are stiffened by
  void restart(const JointGraph::Part& part, std::span<const JointRecord> records,
               const SubstepContext& ctx, bool learn);
  bool adds_energy(const JointGraph::Part& part, const SubstepContext& ctx) const;
  /// Whether what a part loses may be given back: nothing stops inelastically in it.
  bool is_ideal(const JointGraph::Part& part) const;
  /// N s^2, on body b of a node, since the substep began.
  Vec3 impulse(const JointGraph::Part& part, std::uint32_t k, std::uint32_t used) const;
  static void add_pull(const JointGraph::Node& plan, NodeState& node, const Vec3& lambda);

  JointGraph graph_;
  std::vector<NodeState> nodes_;
  std::vector<NodeRows> rows_;  ///< empty where all parts are points
  std::vector<Slot> slots_;
  std::vector<std::uint8_t> turns_freely_;  ///< by slot: as the plan was made
  std::vector<std::uint8_t> primary_;       ///< by slot: the first one of its body
  std::vector<std::uint8_t> passive_;       ///< by part: rigid locks and limits only
  std::vector<PartState> state_;
  std::vector<GroupPart> order_;
  std::vector<double> values_;
  std::vector<double> right_;
};

}  // namespace tandem::pbd
