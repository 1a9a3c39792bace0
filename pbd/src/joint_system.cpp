// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_system.h"

#include <algorithm>

namespace tandem::pbd {
namespace {

std::uint32_t movable(BodyId id, std::span<const SolverBody> bodies) {
  return id.valid() && bodies[id.index].inv_mass > 0.0 ? id.index : JointGraph::kNone;
}

}  // namespace

void JointSystem::build(std::span<const JointRecord> records, std::span<const SolverBody> bodies,
                        const BodyOrder& order) {
  std::vector<JointGraph::Edge> edges;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const JointRecord& r = records[i];
    if (!r.active() || r.used == 0) continue;
    // Known to the graph by their places in the order.
    edges.push_back({.joint = static_cast<std::uint32_t>(i),
                     .a = order.rank(movable(r.def.a, bodies)),
                     .b = order.rank(movable(r.def.b, bodies)),
                     .rows = r.rows(),
                     .point = r.is_point(),
                     .turns_a = !r.def.a.valid() || bodies[r.def.a.index].turns_freely,
                     .turns_b = bodies[r.def.b.index].turns_freely});
  }
  if (!order.natural()) {
    std::sort(edges.begin(), edges.end(), [&](const auto& l, const auto& r) {
      return order.row_before(records[l.joint].def.a, records[l.joint].def.b, l.joint,
                              records[r.joint].def.a, records[r.joint].def.b, r.joint);
    });
  }
  graph_.build(edges);
  graph_.rename_bodies([&](std::uint32_t rank) { return order.slot(rank); });
  nodes_.assign(graph_.nodes().size(), {});
  const bool only_points = std::all_of(graph_.parts().begin(), graph_.parts().end(),
                                       [](const JointGraph::Part& part) { return part.points; });
  rows_.assign(only_points ? 0 : nodes_.size(), {});
  slots_.assign(graph_.bodies().size(), {});
  state_.assign(graph_.parts().size(), {});
  order_.assign(graph_.parts().size(), {});
  turns_freely_.clear();
  for (const std::uint32_t body : graph_.bodies()) {
    turns_freely_.push_back(bodies[body].turns_freely ? 1 : 0);
  }
  primary_.assign(graph_.bodies().size(), 0);
  std::vector<std::uint8_t> seen(bodies.size(), 0);
  for (std::size_t s = 0; s < primary_.size(); ++s) {
    std::uint8_t& before = seen[graph_.bodies()[s]];
    primary_[s] = before == 0 ? 1 : 0;
    before = 1;
  }
  passive_.assign(graph_.parts().size(), 1);
  for (std::size_t p = 0; p < passive_.size(); ++p) {
    const JointGraph::Part& part = graph_.parts()[p];
    for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
      const std::uint32_t joint = graph_.nodes()[k].joint;
      if (joint != kNone && !records[joint].passive) passive_[p] = 0;
    }
  }
  values_.assign(graph_.value_count(), 0.0);
  right_.assign(graph_.right_count(), 0.0);
}

bool JointSystem::fits(std::span<const JointRecord> records,
                       std::span<const SolverBody> bodies) const {
  for (const JointGraph::Node& node : graph_.nodes()) {
    if (node.joint == kNone) continue;
    if (!records[node.joint].active()) return false;  // it broke
    const SixDofJointDef& def = records[node.joint].def;
    if ((movable(def.a, bodies) == kNone) != (node.slot_a == kNone)) return false;
    if ((movable(def.b, bodies) == kNone) != (node.slot_b == kNone)) return false;
  }
  for (std::size_t s = 0; s < turns_freely_.size(); ++s) {
    if (bodies[graph_.bodies()[s]].turns_freely != (turns_freely_[s] != 0)) return false;
  }
  return true;
}

void JointSystem::sort_groups(std::span<const SolverBody> bodies) {
  for (std::uint32_t p = 0; p < part_count(); ++p) {
    order_[p] = {bodies[graph_.bodies()[graph_.parts()[p].body]].group, p};
  }
  std::sort(order_.begin(), order_.end(), [](const GroupPart& x, const GroupPart& y) {
    return x.group != y.group ? x.group < y.group : x.part < y.part;
  });
}

bool JointSystem::is_shared(std::uint32_t p, std::span<const SolverBody> bodies) const {
  const JointGraph::Part& part = graph_.parts()[p];
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    if (bodies[graph_.bodies()[s]].shared) return true;
  }
  return false;
}

void JointSystem::begin(std::uint32_t p, std::span<JointRecord> records, const SubstepContext& ctx,
                        Channel channel) {
  const JointGraph::Part& part = graph_.parts()[p];
  state_[p] = {.channel = channel};
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    slots_[s].q_start = ctx.bodies[graph_.bodies()[s]].q;
  }
  if (channel == Channel::Real) resync_leapfrog(part, records, ctx);
  if (!part.regular) {
    for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
      const SolverBody& body = ctx.bodies[graph_.bodies()[s]];
      slots_[s].v_start = body.v;
      slots_[s].momentum_start = inverse_where_free(body.inv_inertia_w) * body.w;
    }
  }
  if (part.points) {
    begin_points(part, records, ctx, channel);
  } else {
    begin_rows(part, records, ctx, channel);
  }
}

void JointSystem::begin_rows(const JointGraph::Part& part, std::span<JointRecord> records,
                             const SubstepContext& ctx, Channel channel) {
  const SolverBody ground;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    node.n = 0;
    if (plan.joint == kNone) {
      node.n = plan.rows;
      continue;
    }
    JointRecord& record = records[plan.joint];
    node.off = !record.active();
    if (node.off) continue;
    const SixDofJointDef& def = record.def;
    const SolverBody& a = body_of(def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(def.b, ctx.bodies, ground);
    const bool left = ctx.substep > 0 && (a.pushed || b.pushed);
    const bool shared = a.shared || b.shared;
    NodeRows& rows = rows_[k];
    node.lambda.fill(0.0);
    node.lambda_start.fill(0.0);
    rows.last_kind.fill(Segment::Kind::None);
    rows.flips.fill(0);
    double c[kCoordinates];
    coordinates(record, a, b, record.twist, c);
    if ((record.used >> kTwist & 1u) != 0 && channel == Channel::Real) record.twist = c[kTwist];
    take_gradients(node, rows, record, a, b);
    node.pull_a = node.pull_b = 0.0;
    add_pull(plan, node, ctx.h * ctx.h * record.state.force);
    // Force laws.
    for_bits(record.used, [&](int i) {
      const JointAxis axis = record.axis(i);
      if (channel == Channel::Displacement) {
        rows.law[i] = ForceLaw::of_displacement(axis, record.bound[i], ctx.h);
        return;
      }
      double& residual = record.displacement_residual[i];
      residual =
          ForceLaw::begin_residual(axis, c[i], residual, left && (i < 3 || !shared), shared, ctx.h);
      rows.law[i] = ForceLaw::of(axis, c[i], residual, ctx.h);
    });
  }
}

/// Velocities stand half a substep behind poses (leapfrog), so that between substeps of different
/// length gravity acts for half of either. Joints find their own forces; without this a chain that
/// is given more substeps while it falls loses energy each time.
void JointSystem::resync_leapfrog(const JointGraph::Part& part, std::span<JointRecord> records,
                                  const SubstepContext& ctx) {
  double before = 0.0;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const std::uint32_t joint = graph_.nodes()[k].joint;
    if (joint == kNone) continue;
    if (before == 0.0) before = records[joint].h;
    records[joint].h = ctx.h;
  }
  if (before == 0.0 || before == ctx.h) return;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    if (primary_[s] == 0) continue;
    SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    body.v += 0.5 * (before - ctx.h) * body.gravity_scale * ctx.gravity;
  }
}

Vec3 JointSystem::impulse(const JointGraph::Part& part, std::uint32_t k, std::uint32_t used) const {
  const NodeState& node = nodes_[k];
  if (part.points) return Vec3(node.lambda[0], node.lambda[1], node.lambda[2]);
  Vec3 sum = Vec3::Zero();
  for_bits(used & 7u, [&](int i) { sum += node.lambda[i] * rows_[k].dir.col(i); });
  return sum;
}

void JointSystem::finish(std::uint32_t p, std::span<JointRecord> records,
                         const SubstepContext& ctx) {
  const JointGraph::Part& part = graph_.parts()[p];
  if (passive_[p] != 0) limit_energy_gain(part, state_[p].work, records, ctx);
  const double inverse_h2 = 1.0 / (ctx.h * ctx.h);
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const NodeState& node = nodes_[k];
    if (plan.joint == kNone || node.off) continue;
    JointRecord& record = records[plan.joint];
    JointState& state = record.state;
    state.torque.setZero();
    state.load.fill(0.0);
    state.force = inverse_h2 * impulse(part, k, record.used);
    for_bits(record.used, [&](int i) {
      const double load = inverse_h2 * node.lambda[i];
      if (i < 6) state.load[i] = load;
      if (i >= 3) state.torque += load * rows_[k].arm_b.col(i);
    });
    const SixDofJointDef& def = record.def;
    state.broken = (def.break_force > 0.0 && state.force.norm() > def.break_force) ||
                   (def.break_torque > 0.0 && state.torque.norm() > def.break_torque);
    record.broke = state.broken;
  }
}

}  // namespace tandem::pbd
