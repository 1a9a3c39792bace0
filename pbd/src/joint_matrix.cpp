// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_six_dof.h"

namespace tandem::pbd::joint_six_dof {
namespace {

constexpr std::uint32_t kNoSlot = JointGraph::kNone;

/// Sets a hub's diagonal block: its mass, with opposite sign. A held hub and a locked axis count as
/// a unit mass that no joint can reach.
void put_hub(const JointSlot& slot, double* diagonal) {
  Eigen::Map<Eigen::Matrix<double, 6, 6>> mass(diagonal);
  mass.setIdentity();
  if (slot.inv_mass == 0.0) return;
  mass.topLeftCorner<3, 3>() = Mat3::Identity() / slot.inv_mass;
  mass.bottomRightCorner<3, 3>() = inverse_where_free(slot.inv_inertia);
  for (int i = 0; i < 3; ++i) {
    if (slot.inv_inertia(i, i) == 0.0) mass(3 + i, 3 + i) = 1.0;
  }
}

/// Whether both coordinates are displacements; angles have no direction.
bool shifts(int i, int j) { return i < 3 && j < 3; }

/// Sets the lower triangle of a joint's diagonal block.
void put_diagonal(JointData& all, std::uint32_t k) {
  const JointGraph::Node& plan = all.graph.nodes()[k];
  const JointNode& node = all.nodes[k];
  const JointRows& rows = all.rows[k];
  double* diagonal = &all.values[plan.diagonal];
  const auto is_hub = [&](std::uint32_t s) { return s == kNoSlot || all.graph.hubs()[s] != 0; };
  const bool with_a = !is_hub(plan.slot_a);
  const bool with_b = !is_hub(plan.slot_b);
  double inv_mass = 0.0;
  if (with_a) inv_mass += all.slots[plan.slot_a].inv_mass;
  if (with_b) inv_mass += all.slots[plan.slot_b].inv_mass;
  for (int r = 0; r < node.n; ++r) {
    const int i = rows.coordinate[r];
    for (int s = 0; s <= r; ++s) {
      const int j = rows.coordinate[s];
      double sum = shifts(i, j) ? inv_mass * rows.dir.col(i).dot(rows.dir.col(j)) : 0.0;
      if (with_a) sum += rows.arm_a.col(i).dot(rows.b_a.col(j));
      if (with_b) sum += rows.arm_b.col(i).dot(rows.b_b.col(j));
      if (r == s) sum += node.at[r];
      diagonal[r * node.n + s] = sum;
    }
  }
}

void couple_to_hub(JointData& all, const JointGraph::Link& link, bool hub_later) {
  const JointSlot& slot = all.slots[link.slot];
  if (slot.inv_mass == 0.0) return;
  const std::uint32_t k = hub_later ? link.earlier : link.later;
  const JointRows& joint = all.rows[k];
  const int n = all.nodes[k].n;
  const bool is_b = all.graph.nodes()[k].slot_b == link.slot;
  const double sign = is_b ? 1.0 : -1.0;
  const JointRows::Columns& arm = is_b ? joint.arm_b : joint.arm_a;
  double* out = &all.values[link.block];
  for (int r = 0; r < n; ++r) {
    for (int i = 0; i < 3; ++i) {
      const double linear = sign * joint.dir(i, joint.coordinate[r]);
      const bool turns = slot.inv_inertia(i, i) > 0.0;
      const double angular = turns ? sign * arm(i, joint.coordinate[r]) : 0.0;
      out[hub_later ? i * n + r : r * 6 + i] += linear;
      out[hub_later ? (i + 3) * n + r : r * 6 + i + 3] += angular;
    }
  }
}

void couple_joints(JointData& all, const JointGraph::Link& link) {
  const JointSlot& slot = all.slots[link.slot];
  const JointRows& rows_x = all.rows[link.later];
  const JointRows& rows_y = all.rows[link.earlier];
  const bool x_is_b = all.graph.nodes()[link.later].slot_b == link.slot;
  const bool y_is_b = all.graph.nodes()[link.earlier].slot_b == link.slot;
  const double sign = x_is_b == y_is_b ? 1.0 : -1.0;
  const JointRows::Columns& arm = x_is_b ? rows_x.arm_b : rows_x.arm_a;
  const JointRows::Columns& b = y_is_b ? rows_y.b_b : rows_y.b_a;
  const int n = all.nodes[link.earlier].n;
  double* out = &all.values[link.block];
  for (int r = 0; r < all.nodes[link.later].n; ++r) {
    const int i = rows_x.coordinate[r];
    for (int s = 0; s < n; ++s) {
      const int j = rows_y.coordinate[s];
      double sum = arm.col(i).dot(b.col(j));
      if (shifts(i, j)) sum += slot.inv_mass * rows_x.dir.col(i).dot(rows_y.dir.col(j));
      out[r * n + s] += sign * sum;
    }
  }
}

}  // namespace

void assemble(const JointPart& part) {
  JointData& all = part.all;
  std::fill_n(all.values.begin() + part.plan.value, part.plan.value_count, 0.0);
  part.for_nodes([&](std::uint32_t k, const JointGraph::Node& plan, const JointNode&) {
    if (plan.joint == JointGraph::kNone) {
      put_hub(all.slots[plan.slot_b], &all.values[plan.diagonal]);
    } else {
      put_diagonal(all, k);
    }
  });
  for (std::uint32_t l = part.plan.link; l < part.plan.link + part.plan.link_count; ++l) {
    const JointGraph::Link& link = all.graph.links()[l];
    const bool hub_later = all.graph.nodes()[link.later].joint == JointGraph::kNone;
    if (hub_later || all.graph.nodes()[link.earlier].joint == JointGraph::kNone) {
      couple_to_hub(all, link, hub_later);
    } else {
      couple_joints(all, link);
    }
  }
}

}  // namespace tandem::pbd::joint_six_dof
