// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_system.h"

/// The linear algebra of JointSystem: one sparse symmetric system for each part.
namespace tandem::pbd {
void JointSystem::assemble(const JointGraph::Part& part) {
  std::fill_n(values_.begin() + part.value, part.value_count, 0.0);
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const NodeState& node = nodes_[k];
    double* diagonal = &values_[plan.diagonal];
    if (plan.joint == kNone) {
      // A hub's own rows, with the sign turned: its mass. One that is held, and an axis about which
      // it does not turn, counts as a unit mass that no joint can reach.
      const Slot& slot = slots_[plan.slot_b];
      Eigen::Map<Eigen::Matrix<double, 6, 6>> mass(diagonal);
      mass.setIdentity();
      if (slot.inv_mass > 0.0) {
        mass.topLeftCorner<3, 3>() = Mat3::Identity() / slot.inv_mass;
        mass.bottomRightCorner<3, 3>() = inverse_where_free(slot.inv_inertia);
        for (int i = 0; i < 3; ++i) {
          if (slot.inv_inertia(i, i) == 0.0) mass(3 + i, 3 + i) = 1.0;
        }
      }
      continue;
    }
    const auto is_hub = [&](std::uint32_t s) { return s == kNone || graph_.hubs()[s] != 0; };
    const bool with_a = !is_hub(plan.slot_a);
    const bool with_b = !is_hub(plan.slot_b);
    double inv_mass = 0.0;
    if (with_a) inv_mass += slots_[plan.slot_a].inv_mass;
    if (with_b) inv_mass += slots_[plan.slot_b].inv_mass;
    if (node.simple) {
      block::Map3 a(diagonal);
      if (with_a)
        a.noalias() += node.arm_a.leftCols<3>().transpose().lazyProduct(node.b_a.leftCols<3>());
      if (with_b)
        a.noalias() += node.arm_b.leftCols<3>().transpose().lazyProduct(node.b_b.leftCols<3>());
      for (int i = 0; i < 3; ++i) a(i, i) += inv_mass + node.at[i];
      continue;
    }
    for (int r = 0; r < node.n; ++r) {
      const int i = node.coordinate[r];
      for (int s = 0; s <= r; ++s) {
        const int j = node.coordinate[s];
        double sum = inv_mass * node.dir.col(i).dot(node.dir.col(j));
        if (with_a) sum += node.arm_a.col(i).dot(node.b_a.col(j));
        if (with_b) sum += node.arm_b.col(i).dot(node.b_b.col(j));
        if (r == s) sum += node.at[r];
        diagonal[r * node.n + s] = sum;
        diagonal[s * node.n + r] = sum;
      }
    }
  }
  for (std::uint32_t l = part.link; l < part.link + part.link_count; ++l) {
    const JointGraph::Link& link = graph_.links()[l];
    double* out = &values_[link.block];
    const JointGraph::Node& plan_x = graph_.nodes()[link.later];
    const JointGraph::Node& plan_y = graph_.nodes()[link.earlier];
    const NodeState& x = nodes_[link.later];
    const NodeState& y = nodes_[link.earlier];
    const Slot& slot = slots_[link.slot];
    if (plan_x.joint == kNone || plan_y.joint == kNone) {
      if (slot.inv_mass == 0.0) continue;
      const bool hub_later = plan_x.joint == kNone;
      const NodeState& joint = hub_later ? y : x;
      const bool is_b = (hub_later ? plan_y : plan_x).slot_b == link.slot;
      const double sign = is_b ? 1.0 : -1.0;
      const Rows& arm = is_b ? joint.arm_b : joint.arm_a;
      for (int r = 0; r < joint.n; ++r) {
        for (int i = 0; i < 3; ++i) {
          const double linear = sign * joint.dir(i, joint.coordinate[r]);
          const bool turns = slot.inv_inertia(i, i) > 0.0;
          const double angular = turns ? sign * arm(i, joint.coordinate[r]) : 0.0;
          out[hub_later ? i * joint.n + r : r * 6 + i] += linear;
          out[hub_later ? (i + 3) * joint.n + r : r * 6 + i + 3] += angular;
        }
      }
      continue;
    }
    const bool x_is_b = plan_x.slot_b == link.slot;
    const bool y_is_b = plan_y.slot_b == link.slot;
    const double sign = x_is_b == y_is_b ? 1.0 : -1.0;
    const Rows& arm = x_is_b ? x.arm_b : x.arm_a;
    const Rows& b = y_is_b ? y.b_b : y.b_a;
    if (x.simple && y.simple) {
      block::Map3 a(out);
      a.noalias() += sign * arm.leftCols<3>().transpose().lazyProduct(b.leftCols<3>());
      a.diagonal().array() += sign * slot.inv_mass;
      continue;
    }
    for (int r = 0; r < x.n; ++r) {
      const int i = x.coordinate[r];
      for (int s = 0; s < y.n; ++s) {
        const int j = y.coordinate[s];
        out[r * y.n + s] +=
            sign * (slot.inv_mass * x.dir.col(i).dot(y.dir.col(j)) + arm.col(i).dot(b.col(j)));
      }
    }
  }
}

/// Block LDL^T, right-looking; the diagonal blocks end as inverses. Joints have positive pivots,
/// hubs negative ones, stored with their sign turned.
void JointSystem::factor(const JointGraph::Part& part) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const int n = nodes_[k].n;
    if (n == 0) continue;
    double* inverse = &values_[plan.diagonal];
    if (n == 3) {
      block::invert3(inverse);
    } else {
      block::invert(inverse, n);
    }
    const double sign = plan.joint == kNone ? -1.0 : 1.0;
    std::uint32_t update = plan.update;
    for (std::uint32_t i = 0; i < plan.later_count; ++i) {
      const JointGraph::Later& to = graph_.later()[plan.later + i];
      const int rows = nodes_[to.node].n;
      double product[block::kMaxRows * block::kMaxRows];
      block::multiply(&values_[to.block], inverse, rows, n, n, product);
      if (sign < 0.0) {
        for (int e = 0; e < rows * n; ++e) product[e] = -product[e];
      }
      for (std::uint32_t j = 0; j <= i; ++j) {
        const JointGraph::Later& other = graph_.later()[plan.later + j];
        const std::uint32_t target = graph_.updates()[update++];
        if (i == j && graph_.nodes()[to.node].joint == kNone) {
          // A hub's diagonal is stored with its sign turned.
          for (int e = 0; e < rows * n; ++e) product[e] = -product[e];
        }
        block::subtract_product(product, &values_[other.block], rows, n, nodes_[other.node].n,
                                &values_[target]);
      }
    }
  }
}

void JointSystem::solve(const JointGraph::Part& part) {
  const auto times_inverse = [&](const JointGraph::Node& plan, int n, const double* x, double* y) {
    block::times(&values_[plan.diagonal], x, n, plan.joint == kNone ? -1.0 : 1.0, y);
  };
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const int n = nodes_[k].n;
    if (n == 0) continue;
    double* right = &right_[plan.right];
    double x[block::kMaxRows];
    times_inverse(plan, n, right, x);
    std::copy_n(x, n, right);
    for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
      const JointGraph::Later& to = graph_.later()[l];
      block::subtract(&values_[to.block], x, nodes_[to.node].n, n,
                      &right_[graph_.nodes()[to.node].right]);
    }
  }
  for (std::uint32_t k = part.node + part.node_count; k-- > part.node;) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const int n = nodes_[k].n;
    if (n == 0 || plan.later_count == 0) continue;
    double sum[block::kMaxRows] = {};
    for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
      const JointGraph::Later& to = graph_.later()[l];
      block::subtract_transposed(&values_[to.block], &right_[graph_.nodes()[to.node].right],
                                 nodes_[to.node].n, n, sum);
    }
    double x[block::kMaxRows];
    times_inverse(plan, n, sum, x);
    double* right = &right_[plan.right];
    for (int i = 0; i < n; ++i) right[i] += x[i];
  }
}

}  // namespace tandem::pbd
