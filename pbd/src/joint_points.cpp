// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_system.h"

/// Parts of the joint graph that are made of ball joints alone: the same rows as any, in three by
/// three blocks that are always there. A joint that breaks within a step keeps a block of its own.
namespace tandem::pbd {
namespace {

/// m [r]x
[[gnu::always_inline]] inline Mat3 times_skew(const Mat3& m, const Vec3& r) {
  Mat3 out;
  out.col(0) = r.z() * m.col(1) - r.y() * m.col(2);
  out.col(1) = r.x() * m.col(2) - r.z() * m.col(0);
  out.col(2) = r.y() * m.col(0) - r.x() * m.col(1);
  return out;
}

/// a += sign [r]x^T m
[[gnu::always_inline]] inline void add_skew_times(const Vec3& r, const Mat3& m, double sign,
                                                  double* a) {
  const double x = sign * r.x();
  const double y = sign * r.y();
  const double z = sign * r.z();
  for (int j = 0; j < 3; ++j) {
    a[j] += z * m(1, j) - y * m(2, j);
    a[3 + j] += x * m(2, j) - z * m(0, j);
    a[6 + j] += y * m(0, j) - x * m(1, j);
  }
}

}  // namespace

void JointSystem::begin_points(const JointGraph::Part& part, std::span<JointRecord> records,
                               const SubstepContext& ctx, Channel channel) {
  const SolverBody ground;
  const double h2 = ctx.h * ctx.h;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    JointRecord& record = records[plan.joint];
    node.n = 3;
    node.lambda.fill(0.0);
    node.lambda_start.fill(0.0);
    node.off = !record.active();
    if (node.off) continue;
    const SolverBody& a = body_of(record.def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(record.def.b, ctx.bodies, ground);
    const bool left = ctx.substep > 0 && (a.pushed || b.pushed);
    const bool shared = a.shared || b.shared;
    const JointPlace place = JointPlace::of(record.def, a, b);
    for (int i = 0; i < 3; ++i) {
      node.r_a[i] = place.r_a[i];
      node.r_b[i] = place.r_b[i];
    }
    node.pull_a = node.pull_b = 0.0;
    add_pull(plan, node, h2 * record.state.force);
    for (int i = 0; i < 3; ++i) {
      const JointAxis& axis = record.def.linear[static_cast<std::size_t>(i)];
      ForceLaw law;
      if (channel == Channel::Real) {
        double& residual = record.displacement_residual[i];
        residual = ForceLaw::begin_residual(axis, place.d[i], residual, left, shared, ctx.h);
        law = ForceLaw::of(axis, place.d[i], residual, ctx.h);
      } else {
        law = ForceLaw::of_displacement(axis, record.bound[i], ctx.h);
      }
      node.target[i] = law.target;
      node.softness = law.at;
    }
  }
}

void JointSystem::evaluate_points(const JointGraph::Part& part,
                                  std::span<const JointRecord> records, const SubstepContext& ctx) {
  const SolverBody ground;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const NodeState& node = nodes_[k];
    Eigen::Map<Vec3> right(&right_[plan.right]);
    if (node.off) {
      right.setZero();
      continue;
    }
    const SixDofJointDef& def = records[plan.joint].def;
    const SolverBody& a = body_of(def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(def.b, ctx.bodies, ground);
    const Vec3 r_a = rotate(a.q, def.frame_a.anchor);
    const Vec3 r_b = rotate(b.q, def.frame_b.anchor);
    for (int i = 0; i < 3; ++i) {
      const double d = (b.x[i] + r_b[i]) - (a.x[i] + r_a[i]);
      right[i] = -(d - node.target[i]) - node.at[i] * node.lambda[i];
    }
  }
}

void JointSystem::assemble_points(const JointGraph::Part& part, const PartState& state) {
  std::fill_n(values_.begin() + part.value, part.value_count, 0.0);
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    double* diagonal = &values_[plan.diagonal];
    if (node.off) {
      block::Map3(diagonal).setIdentity();
      continue;
    }
    double inv_mass = 0.0;
    if (plan.slot_a != kNone) {
      const Slot& slot = slots_[plan.slot_a];
      inv_mass += slot.inv_mass;
      node.b_a = times_skew(slot.inv_inertia, node.r_a);
      add_skew_times(node.r_a, node.b_a, 1.0, diagonal);
    }
    if (plan.slot_b != kNone) {
      const Slot& slot = slots_[plan.slot_b];
      inv_mass += slot.inv_mass;
      node.b_b = times_skew(slot.inv_inertia, node.r_b);
      add_skew_times(node.r_b, node.b_b, 1.0, diagonal);
    }
    for (int i = 0; i < 3; ++i) {
      double& pivot = diagonal[4 * i];
      pivot += inv_mass;
      node.at[i] = part.regular ? node.softness : std::max(node.softness, state.redundancy * pivot);
      pivot += node.at[i];
    }
  }
  for (std::uint32_t l = part.link; l < part.link + part.link_count; ++l) {
    const JointGraph::Link& link = graph_.links()[l];
    const NodeState& x = nodes_[link.later];
    const NodeState& y = nodes_[link.earlier];
    if (x.off || y.off) continue;
    const bool x_is_b = graph_.nodes()[link.later].slot_b == link.slot;
    const bool y_is_b = graph_.nodes()[link.earlier].slot_b == link.slot;
    const double sign = x_is_b == y_is_b ? 1.0 : -1.0;
    double* out = &values_[link.block];
    add_skew_times(x_is_b ? x.r_b : x.r_a, y_is_b ? y.b_b : y.b_a, sign, out);
    const double inv_mass = sign * slots_[link.slot].inv_mass;
    for (int i = 0; i < 3; ++i) out[4 * i] += inv_mass;
  }
}

void JointSystem::gather_points(const JointGraph::Part& part) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    const Vec3 p = Eigen::Map<const Vec3>(&right_[plan.right]);
    for (int i = 0; i < 3; ++i) node.lambda[i] += p[i];
    // Impulses first; what they move comes once for each body.
    if (plan.slot_a != kNone) {
      Slot& slot = slots_[plan.slot_a];
      slot.dx -= p;
      slot.dtheta -= node.r_a.cross(p);
    }
    if (plan.slot_b != kNone) {
      Slot& slot = slots_[plan.slot_b];
      slot.dx += p;
      slot.dtheta += node.r_b.cross(p);
    }
  }
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    Slot& slot = slots_[s];
    slot.dx *= slot.inv_mass;
    slot.dtheta = block::times(slot.inv_inertia, slot.dtheta);
  }
}

}  // namespace tandem::pbd
