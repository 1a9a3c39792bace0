// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_factor.h"

namespace tandem::pbd {
namespace {

/// Eliminates a node of n rows.
/// @param size  rows of a node
template <int n>
void eliminate(JointData& all, const JointGraph::Node& plan, auto&& size) {
  double* inverse = &all.values[plan.diagonal];
  if constexpr (n == 3) {
    block::invert3(inverse);
  } else {
    block::invert<n>(inverse);
  }
  const double sign = plan.joint == JointGraph::kNone ? -1.0 : 1.0;
  std::uint32_t update = plan.update;
  for (std::uint32_t i = 0; i < plan.later_count; ++i) {
    const JointGraph::Later& to = all.graph.later()[plan.later + i];
    const auto rows = size(to.node);
    double* const own = &all.values[to.block];
    double product[block::kMaxRows * n];
    block::multiply<n>(own, inverse, rows, sign, product);
    // Earlier ones are blocks of L by now.
    for (std::uint32_t j = 0; j < i; ++j) {
      const JointGraph::Later& other = all.graph.later()[plan.later + j];
      block::subtract_product<n>(own, &all.values[other.block], rows, size(other.node),
                                 &all.values[all.graph.updates()[update++]]);
    }
    if (all.graph.nodes()[to.node].joint == JointGraph::kNone) block::negate(own, rows * n);
    block::subtract_symmetric<n>(product, own, rows, &all.values[all.graph.updates()[update++]]);
    std::copy_n(product, rows * n, own);
  }
}

/// Right-looking. Joints have positive pivots; hubs have negative ones, stored with opposite sign.
void factor(const JointPart& part, auto&& size) {
  JointData& all = part.all;
  for (std::uint32_t k = part.plan.node; k < part.plan.node + part.plan.node_count; ++k) {
    block::with_size(size(k), [&](auto n) { eliminate<n>(all, all.graph.nodes()[k], size); });
  }
}

void solve(const JointPart& part, auto&& size) {
  JointData& all = part.all;
  for (std::uint32_t k = part.plan.node; k < part.plan.node + part.plan.node_count; ++k) {
    const JointGraph::Node& plan = all.graph.nodes()[k];
    block::with_size(size(k), [&](auto n) {
      for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
        const JointGraph::Later& to = all.graph.later()[l];
        block::subtract<n>(&all.values[to.block], &all.right[plan.right], size(to.node),
                           &all.right[to.right]);
      }
    });
  }
  for (std::uint32_t k = part.plan.node + part.plan.node_count; k-- > part.plan.node;) {
    const JointGraph::Node& plan = all.graph.nodes()[k];
    block::with_size(size(k), [&](auto n) {
      double x[n];
      block::times<n>(&all.values[plan.diagonal], &all.right[plan.right],
                      plan.joint == JointGraph::kNone ? -1.0 : 1.0, x);
      for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
        const JointGraph::Later& to = all.graph.later()[l];
        block::subtract_transposed<n>(&all.values[to.block], &all.right[to.right], size(to.node),
                                      x);
      }
      std::copy_n(x, static_cast<int>(n), &all.right[plan.right]);
    });
  }
}

}  // namespace

void factor(const JointPart& part) {
  if (part.plan.points) {
    factor(part, [](std::uint32_t) { return std::integral_constant<int, 3>{}; });
  } else {
    factor(part, [&](std::uint32_t k) { return part.all.nodes[k].n; });
  }
}

void solve(const JointPart& part) {
  if (part.plan.points) {
    solve(part, [](std::uint32_t) { return std::integral_constant<int, 3>{}; });
  } else {
    solve(part, [&](std::uint32_t k) { return part.all.nodes[k].n; });
  }
}

}  // namespace tandem::pbd
