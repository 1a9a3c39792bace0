// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_system.h"

/// The linear algebra of JointSystem: one sparse symmetric system for each part.
namespace tandem::pbd {

void JointSystem::assemble(const JointGraph::Part& part) {
  std::fill_n(values_.begin() + part.value, part.value_count, 0.0);
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    if (plan.joint == kNone) {
      put_hub(slots_[plan.slot_b], &values_[plan.diagonal]);
    } else {
      put_diagonal(k);
    }
  }
  for (std::uint32_t l = part.link; l < part.link + part.link_count; ++l) {
    const JointGraph::Link& link = graph_.links()[l];
    const bool hub_later = graph_.nodes()[link.later].joint == kNone;
    if (hub_later || graph_.nodes()[link.earlier].joint == kNone) {
      couple_to_hub(link, hub_later);
    } else {
      couple_joints(link);
    }
  }
}

/// A hub's own rows, with the sign turned: its mass. One that is held, and an axis about which it
/// does not turn, counts as a unit mass that no joint can reach.
void JointSystem::put_hub(const Slot& slot, double* diagonal) {
  Eigen::Map<Eigen::Matrix<double, 6, 6>> mass(diagonal);
  mass.setIdentity();
  if (slot.inv_mass == 0.0) return;
  mass.topLeftCorner<3, 3>() = Mat3::Identity() / slot.inv_mass;
  mass.bottomRightCorner<3, 3>() = inverse_where_free(slot.inv_inertia);
  for (int i = 0; i < 3; ++i) {
    if (slot.inv_inertia(i, i) == 0.0) mass(3 + i, 3 + i) = 1.0;
  }
}

void JointSystem::put_diagonal(std::uint32_t k) {
  const JointGraph::Node& plan = graph_.nodes()[k];
  const NodeState& node = nodes_[k];
  const NodeRows& rows = rows_[k];
  double* diagonal = &values_[plan.diagonal];
  const auto is_hub = [&](std::uint32_t s) { return s == kNone || graph_.hubs()[s] != 0; };
  const bool with_a = !is_hub(plan.slot_a);
  const bool with_b = !is_hub(plan.slot_b);
  double inv_mass = 0.0;
  if (with_a) inv_mass += slots_[plan.slot_a].inv_mass;
  if (with_b) inv_mass += slots_[plan.slot_b].inv_mass;
  for (int r = 0; r < node.n; ++r) {
    const int i = rows.coordinate[r];
    for (int s = 0; s <= r; ++s) {
      const int j = rows.coordinate[s];
      double sum = inv_mass * rows.dir.col(i).dot(rows.dir.col(j));
      if (with_a) sum += rows.arm_a.col(i).dot(rows.b_a.col(j));
      if (with_b) sum += rows.arm_b.col(i).dot(rows.b_b.col(j));
      if (r == s) sum += node.at[r];
      diagonal[r * node.n + s] = sum;
      diagonal[s * node.n + r] = sum;
    }
  }
}

void JointSystem::couple_to_hub(const JointGraph::Link& link, bool hub_later) {
  const Slot& slot = slots_[link.slot];
  if (slot.inv_mass == 0.0) return;
  const std::uint32_t k = hub_later ? link.earlier : link.later;
  const NodeRows& joint = rows_[k];
  const int n = nodes_[k].n;
  const bool is_b = graph_.nodes()[k].slot_b == link.slot;
  const double sign = is_b ? 1.0 : -1.0;
  const Rows& arm = is_b ? joint.arm_b : joint.arm_a;
  double* out = &values_[link.block];
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

void JointSystem::couple_joints(const JointGraph::Link& link) {
  const Slot& slot = slots_[link.slot];
  const NodeRows& rows_x = rows_[link.later];
  const NodeRows& rows_y = rows_[link.earlier];
  const bool x_is_b = graph_.nodes()[link.later].slot_b == link.slot;
  const bool y_is_b = graph_.nodes()[link.earlier].slot_b == link.slot;
  const double sign = x_is_b == y_is_b ? 1.0 : -1.0;
  const Rows& arm = x_is_b ? rows_x.arm_b : rows_x.arm_a;
  const Rows& b = y_is_b ? rows_y.b_b : rows_y.b_a;
  const int n = nodes_[link.earlier].n;
  double* out = &values_[link.block];
  for (int r = 0; r < nodes_[link.later].n; ++r) {
    const int i = rows_x.coordinate[r];
    for (int s = 0; s < n; ++s) {
      const int j = rows_y.coordinate[s];
      out[r * n + s] += sign * (slot.inv_mass * rows_x.dir.col(i).dot(rows_y.dir.col(j)) +
                                arm.col(i).dot(b.col(j)));
    }
  }
}

/// Block LDL^T, right-looking; the diagonal blocks end as inverses, the others as blocks of L.
/// Joints have positive pivots, hubs negative ones, stored with their sign turned.
/// @param size  of a node: its rows
template <class Size>
void JointSystem::factor(const JointGraph::Part& part, Size&& size) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const int n = size(k);
    if (n == 0) continue;
    double* inverse = &values_[plan.diagonal];
    if (n == 3) {
      block::invert3(inverse);
    } else {
      block::invert(inverse, n);
    }
    std::uint32_t update = plan.update;
    for (std::uint32_t i = 0; i < plan.later_count; ++i) {
      const JointGraph::Later& to = graph_.later()[plan.later + i];
      const int rows = size(to.node);
      double* const own = &values_[to.block];
      double product[block::kMaxRows * block::kMaxRows];
      block::multiply(own, inverse, rows, n, n, product);
      if (plan.joint == kNone) block::negate(product, rows * n);
      // Those before it are blocks of L by now.
      for (std::uint32_t j = 0; j < i; ++j) {
        const JointGraph::Later& other = graph_.later()[plan.later + j];
        block::subtract_product(own, &values_[other.block], rows, n, size(other.node),
                                &values_[graph_.updates()[update++]]);
      }
      if (graph_.nodes()[to.node].joint == kNone) block::negate(own, rows * n);
      block::subtract_product(product, own, rows, n, rows, &values_[graph_.updates()[update++]]);
      std::copy_n(product, rows * n, own);
    }
  }
}

template <class Size>
void JointSystem::solve(const JointGraph::Part& part, Size&& size) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
      const JointGraph::Later& to = graph_.later()[l];
      block::subtract(&values_[to.block], &right_[plan.right], size(to.node), size(k),
                      &right_[to.right]);
    }
  }
  for (std::uint32_t k = part.node + part.node_count; k-- > part.node;) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const int n = size(k);
    double x[block::kMaxRows];
    block::times(&values_[plan.diagonal], &right_[plan.right], n, plan.joint == kNone ? -1.0 : 1.0,
                 x);
    for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
      const JointGraph::Later& to = graph_.later()[l];
      block::subtract_transposed(&values_[to.block], &right_[to.right], size(to.node), n, x);
    }
    std::copy_n(x, n, &right_[plan.right]);
  }
}

void JointSystem::factor(const JointGraph::Part& part) {
  if (part.points) {
    factor(part, [](std::uint32_t) { return 3; });
  } else {
    factor(part, [this](std::uint32_t k) { return nodes_[k].n; });
  }
}

void JointSystem::solve(const JointGraph::Part& part) {
  if (part.points) {
    solve(part, [](std::uint32_t) { return 3; });
  } else {
    solve(part, [this](std::uint32_t k) { return nodes_[k].n; });
  }
}

}  // namespace tandem::pbd
