// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_points.h"

namespace tandem::pbd::joint_points {
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

void begin(const JointPart& part) {
  const SolverBody ground;
  const SubstepContext& ctx = part.ctx;
  const double h2 = ctx.h * ctx.h;
  part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, JointNode& node) {
    JointRecord& record = part.records[plan.joint];
    node.n = 3;
    node.lambda.fill(0.0);
    node.lambda_start.fill(0.0);
    node.off = !record.active();
    if (node.off) return;
    const SolverBody& a = body_of(record.def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(record.def.b, ctx.bodies, ground);
    const bool left = ctx.substep > 0 && (a.pushed || b.pushed);
    const bool displaced = a.shared || b.shared;
    const JointPlace place = JointPlace::of(record.def, a, b);
    for (int i = 0; i < 3; ++i) {
      node.r_a[i] = place.r_a[i];
      node.r_b[i] = place.r_b[i];
    }
    node.pull_a = node.pull_b = 0.0;
    node.add_pull(plan, h2 * record.state.force);
    for (int i = 0; i < 3; ++i) {
      const JointAxis& axis = record.def.linear[static_cast<std::size_t>(i)];
      ForceLaw law;
      if (part.progress.channel == JointChannel::Real) {
        double& residual = record.displacement_residual[i];
        residual = residual_at_start(axis, place.d[i], residual, left, displaced, ctx.h, kLeft);
        set_force_law(law, axis, place.d[i], residual, ctx.h);
      } else {
        law = displacement_law(axis, record.bound[i], ctx.h);
      }
      node.target[i] = law.target;
      node.softness = law.at;
    }
  });
}

void warm_start(const JointPart& part) {
  part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, const JointNode& node) {
    Eigen::Map<Vec3> right(&part.all.right[plan.right]);
    right.setZero();
    if (!node.off) right = part.ctx.h * part.ctx.h * part.records[plan.joint].state.force;
  });
  gather(part);
}

void take_gradients(const JointPart& part) {
  const SolverBody ground;
  part.for_joints([&](std::uint32_t, const JointGraph::Node& plan, JointNode& node) {
    const SixDofJointDef& def = part.records[plan.joint].def;
    node.r_a = rotate(body_of(def.a, part.ctx.bodies, ground).q, def.frame_a.anchor);
    node.r_b = rotate(body_of(def.b, part.ctx.bodies, ground).q, def.frame_b.anchor);
  });
}

void weigh(const JointPart& part) {
  const std::vector<JointSlot>& slots = part.all.slots;
  part.for_joints([&](std::uint32_t, const JointGraph::Node& plan, JointNode& node) {
    for (int i = 0; i < 3; ++i) {
      double w = 0.0;
      const auto add = [&](std::uint32_t slot, const Vec3& r) {
        if (part.plan.regular || slot == JointGraph::kNone) return;
        const Vec3 arm = r.cross(Vec3::Unit(i));
        w += slots[slot].inv_mass + arm.dot(block::times(slots[slot].inv_inertia, arm));
      };
      add(plan.slot_a, node.r_a);
      add(plan.slot_b, node.r_b);
      node.at[i] = std::max(node.softness, part.progress.redundancy * w);
    }
  });
}

void evaluate(const JointPart& part) {
  const SolverBody ground;
  part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, const JointNode& node) {
    Eigen::Map<Vec3> right(&part.all.right[plan.right]);
    if (node.off) {
      right.setZero();
      return;
    }
    const SixDofJointDef& def = part.records[plan.joint].def;
    const SolverBody& a = body_of(def.a, part.ctx.bodies, ground);
    const SolverBody& b = body_of(def.b, part.ctx.bodies, ground);
    const Vec3 r_a = rotate(a.q, def.frame_a.anchor);
    const Vec3 r_b = rotate(b.q, def.frame_b.anchor);
    for (int i = 0; i < 3; ++i) {
      const double d = (b.x[i] + r_b[i]) - (a.x[i] + r_a[i]);
      right[i] = -(d - node.target[i]) - node.at[i] * node.lambda[i];
    }
  });
}

void assemble(const JointPart& part) {
  const JointGraph& graph = part.all.graph;
  std::vector<JointNode>& nodes = part.all.nodes;
  const std::vector<JointSlot>& slots = part.all.slots;
  std::vector<double>& values = part.all.values;
  std::fill_n(values.begin() + part.plan.value, part.plan.value_count, 0.0);
  for (std::uint32_t k = part.plan.node; k < part.plan.node + part.plan.node_count; ++k) {
    const JointGraph::Node& plan = graph.nodes()[k];
    JointNode& node = nodes[k];
    double* diagonal = &values[plan.diagonal];
    if (node.off) {
      block::Map3(diagonal).setIdentity();
      continue;
    }
    double inv_mass = 0.0;
    if (plan.slot_a != JointGraph::kNone) {
      const JointSlot& slot = slots[plan.slot_a];
      inv_mass += slot.inv_mass;
      node.b_a = times_skew(slot.inv_inertia, node.r_a);
      add_skew_times(node.r_a, node.b_a, 1.0, diagonal);
    }
    if (plan.slot_b != JointGraph::kNone) {
      const JointSlot& slot = slots[plan.slot_b];
      inv_mass += slot.inv_mass;
      node.b_b = times_skew(slot.inv_inertia, node.r_b);
      add_skew_times(node.r_b, node.b_b, 1.0, diagonal);
    }
    for (int i = 0; i < 3; ++i) diagonal[4 * i] += inv_mass + node.at[i];
  }
  for (std::uint32_t l = part.plan.link; l < part.plan.link + part.plan.link_count; ++l) {
    const JointGraph::Link& link = graph.links()[l];
    const JointNode& x = nodes[link.later];
    const JointNode& y = nodes[link.earlier];
    if (x.off || y.off) continue;
    const bool x_is_b = graph.nodes()[link.later].slot_b == link.slot;
    const bool y_is_b = graph.nodes()[link.earlier].slot_b == link.slot;
    const double sign = x_is_b == y_is_b ? 1.0 : -1.0;
    double* out = &values[link.block];
    add_skew_times(x_is_b ? x.r_b : x.r_a, y_is_b ? y.b_b : y.b_a, sign, out);
    const double inv_mass = sign * slots[link.slot].inv_mass;
    for (int i = 0; i < 3; ++i) out[4 * i] += inv_mass;
  }
}

void gather(const JointPart& part) {
  std::vector<JointSlot>& slots = part.all.slots;
  part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, JointNode& node) {
    const Vec3 p = Eigen::Map<const Vec3>(&part.all.right[plan.right]);
    for (int i = 0; i < 3; ++i) node.lambda[i] += p[i];
    // Impulses first; each body's move then follows once.
    if (plan.slot_a != JointGraph::kNone) {
      JointSlot& slot = slots[plan.slot_a];
      slot.dx -= p;
      slot.dtheta -= node.r_a.cross(p);
    }
    if (plan.slot_b != JointGraph::kNone) {
      JointSlot& slot = slots[plan.slot_b];
      slot.dx += p;
      slot.dtheta += node.r_b.cross(p);
    }
  });
  part.for_bodies([](JointSlot& slot, const SolverBody&) {
    slot.dx *= slot.inv_mass;
    slot.dtheta = block::times(slot.inv_inertia, slot.dtheta);
  });
}

}  // namespace tandem::pbd::joint_points
