// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_system.h"

#include <algorithm>
#include <utility>

#include "joint_newton.h"
#include "joint_points.h"
#include "joint_six_dof.h"
#include "joint_stability.h"

namespace tandem::pbd {
namespace {

std::uint32_t movable(BodyId id, std::span<const SolverBody> bodies) {
  return id.valid() && bodies[id.index].inv_mass > 0.0 ? id.index : JointGraph::kNone;
}

/// Whether the joint may have rows.
bool is_planned(const JointRecord& record) { return record.active() && record.used != 0; }

/// Velocities are half a substep behind poses (leapfrog). Between substeps of different length
/// gravity therefore acts for half of each. Joints find their own forces. Without this a falling
/// chain loses energy each time it is refined.
void resync_leapfrog(const JointPart& part) {
  const SubstepContext& ctx = part.ctx;
  double before = 0.0;
  part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, const JointNode&) {
    if (plan.joint == JointGraph::kNone) return;
    if (before == 0.0) before = part.records[plan.joint].last.h;
    part.records[plan.joint].last.h = ctx.h;
  });
  if (before == 0.0 || before == ctx.h) return;
  part.for_bodies([&](const JointSlot& slot, SolverBody& body) {
    if (slot.primary) body.v += 0.5 * (before - ctx.h) * body.gravity_scale * ctx.gravity;
  });
}

}  // namespace

void JointSystem::build(std::span<const JointRecord> records, std::span<const SolverBody> bodies,
                        const BodyOrder& order) {
  std::vector<JointGraph::Edge> edges;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const JointRecord& r = records[i];
    if (!is_planned(r)) continue;
    // Joints are known to the graph by their place in the order.
    edges.push_back({.joint = static_cast<std::uint32_t>(i),
                     .a = order.rank(movable(r.def.a, bodies)),
                     .b = order.rank(movable(r.def.b, bodies)),
                     .rows = r.room(),
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
  data_.graph.build(edges);
  data_.graph.rename_bodies([&](std::uint32_t rank) { return order.slot(rank); });
  data_.nodes.assign(data_.graph.nodes().size(), {});
  const bool only_points = std::all_of(data_.graph.parts().begin(), data_.graph.parts().end(),
                                       [](const JointGraph::Part& part) { return part.points; });
  data_.rows.assign(only_points ? 0 : data_.nodes.size(), {});
  data_.slots.assign(data_.graph.bodies().size(), {});
  progress_.assign(data_.graph.parts().size(), {});
  order_.assign(data_.graph.parts().size(), {});
  std::vector<std::uint8_t> seen(bodies.size(), 0);
  for (std::size_t s = 0; s < data_.slots.size(); ++s) {
    const std::uint32_t body = data_.graph.bodies()[s];
    data_.slots[s].turns_freely = bodies[body].turns_freely;
    data_.slots[s].primary = std::exchange(seen[body], 1) == 0;
  }
  data_.values.assign(data_.graph.value_count(), 0.0);
  data_.right.assign(data_.graph.right_count(), 0.0);
}

bool JointSystem::fits(std::span<const JointRecord> records,
                       std::span<const SolverBody> bodies) const {
  std::size_t planned = 0;
  for (const JointGraph::Node& node : data_.graph.nodes()) {
    if (node.joint == JointGraph::kNone) continue;
    const JointRecord& record = records[node.joint];
    if (!is_planned(record) || record.is_point() != node.point || record.rows() > node.rows)
      return false;
    ++planned;
    const SixDofJointDef& def = record.def;
    if ((movable(def.a, bodies) == JointGraph::kNone) != (node.slot_a == JointGraph::kNone))
      return false;
    if ((movable(def.b, bodies) == JointGraph::kNone) != (node.slot_b == JointGraph::kNone))
      return false;
  }
  for (const JointRecord& record : records) {
    if (is_planned(record) && (movable(record.def.a, bodies) != JointGraph::kNone ||
                               movable(record.def.b, bodies) != JointGraph::kNone)) {
      --planned;
    }
  }
  if (planned != 0) return false;
  for (std::size_t s = 0; s < data_.slots.size(); ++s) {
    if (bodies[data_.graph.bodies()[s]].turns_freely != data_.slots[s].turns_freely) return false;
  }
  return true;
}

void JointSystem::note_passive(std::span<const JointRecord> records) {
  passive_.assign(data_.graph.parts().size(), 1);
  for (std::size_t p = 0; p < passive_.size(); ++p) {
    const JointGraph::Part& part = data_.graph.parts()[p];
    for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
      const std::uint32_t joint = data_.graph.nodes()[k].joint;
      if (joint != JointGraph::kNone && !records[joint].passive) passive_[p] = 0;
    }
  }
}

void JointSystem::sort_groups(std::span<const SolverBody> bodies) {
  for (std::uint32_t p = 0; p < part_count(); ++p) {
    order_[p] = {bodies[data_.graph.bodies()[data_.graph.parts()[p].body]].group, p};
  }
  std::sort(order_.begin(), order_.end(), [](const GroupPart& x, const GroupPart& y) {
    return x.group != y.group ? x.group < y.group : x.part < y.part;
  });
}

bool JointSystem::is_shared(std::uint32_t p, std::span<const SolverBody> bodies) const {
  const JointGraph::Part& part = data_.graph.parts()[p];
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    if (bodies[data_.graph.bodies()[s]].shared) return true;
  }
  return false;
}

JointPart JointSystem::part_of(std::uint32_t p, std::span<JointRecord> records,
                               const SubstepContext& ctx) {
  return {data_, data_.graph.parts()[p], progress_[p], passive_[p] != 0, records, ctx};
}

void JointSystem::begin(std::uint32_t p, std::span<JointRecord> records, const SubstepContext& ctx,
                        JointChannel channel) {
  progress_[p] = {.channel = channel};
  const JointPart part = part_of(p, records, ctx);
  part.for_bodies([&](JointSlot& slot, const SolverBody& body) {
    slot.q_start = body.q;
    if (ctx.substep == 0) slot.local.inertia.setZero();
  });
  if (channel == JointChannel::Real) resync_leapfrog(part);
  if (channel == JointChannel::Displacement) {
    part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, const JointNode&) {
      if (plan.joint == JointGraph::kNone) return;
      progress_[p].closing = progress_[p].closing || records[plan.joint].gap.is_open();
    });
  }
  if (!part.plan.regular) {
    part.for_bodies([](JointSlot& slot, const SolverBody& body) {
      slot.start.v = body.v;
      slot.start.momentum = inverse_where_free(body.inv_inertia_w) * body.w;
    });
  }
  if (part.plan.points) {
    joint_points::begin(part);
  } else {
    joint_six_dof::begin(part);
  }
}

double JointSystem::iterate(std::uint32_t p, std::span<JointRecord> records,
                            const SubstepContext& ctx) {
  return newton_iteration(part_of(p, records, ctx));
}

void JointSystem::finish_projection(std::uint32_t p, std::span<JointRecord> records,
                                    const SubstepContext& ctx) {
  const JointPart part = part_of(p, records, ctx);
  if (part.passive) limit_turn(part);
}

void JointSystem::finish(std::uint32_t p, std::span<JointRecord> records,
                         const SubstepContext& ctx) {
  const JointPart part = part_of(p, records, ctx);
  if (part.passive) limit_energy_gain(part);
  const double inverse_h2 = 1.0 / (ctx.h * ctx.h);
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, const JointNode& node) {
    JointRecord& record = records[plan.joint];
    JointState& state = record.state;
    record.clear_forces();
    state.force = inverse_h2 * part.impulse(k, record.used);
    for_bits(record.used, [&](int i) {
      const double load = inverse_h2 * node.lambda[i];
      record.last.forces[i] = load;
      if (i < 6) state.load[i] = load;
      if (i >= 3) state.torque += load * data_.rows[k].arm_b.col(i);
      if (record.axis(i).armature > 0.0) {
        const JointRows& rows = data_.rows[k];
        const double moved = rows.law[i].coordinate(node.lambda[i]) - rows.start[i];
        record.last.rotors[i] = moved / ctx.h;
      }
    });
    record.last.rotors_known = true;
    const SixDofJointDef& def = record.def;
    state.broken = (def.break_force > 0.0 && state.force.norm() > def.break_force) ||
                   (def.break_torque > 0.0 && state.torque.norm() > def.break_torque);
    record.broke = state.broken;
  });
}

}  // namespace tandem::pbd
