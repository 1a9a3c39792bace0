// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_factor.h"

namespace tandem::pbd {
namespace {

/// Right-looking. Joints have positive pivots; hubs have negative ones, stored with opposite sign.
/// @param size  rows of a node
void factor(const JointPart& part, auto&& size) {
  JointData& all = part.all;
  for (std::uint32_t k = part.plan.node; k < part.plan.node + part.plan.node_count; ++k) {
    const JointGraph::Node& plan = all.graph.nodes()[k];
    const int n = size(k);
    if (n == 0) continue;
    double* inverse = &all.values[plan.diagonal];
    if (n == 3) {
      block::invert3(inverse);
    } else {
      block::invert(inverse, n);
    }
    std::uint32_t update = plan.update;
    for (std::uint32_t i = 0; i < plan.later_count; ++i) {
      const JointGraph::Later& to = all.graph.later()[plan.later + i];
      const int rows = size(to.node);
      double* const own = &all.values[to.block];
      double product[block::kMaxRows * block::kMaxRows];
      block::multiply(own, inverse, rows, n, n, product);
      if (plan.joint == JointGraph::kNone) block::negate(product, rows * n);
      // Earlier ones are blocks of L by now.
      for (std::uint32_t j = 0; j < i; ++j) {
        const JointGraph::Later& other = all.graph.later()[plan.later + j];
        block::subtract_product(own, &all.values[other.block], rows, n, size(other.node),
                                &all.values[all.graph.updates()[update++]]);
      }
      if (all.graph.nodes()[to.node].joint == JointGraph::kNone) block::negate(own, rows * n);
      block::subtract_product(product, own, rows, n, rows,
                              &all.values[all.graph.updates()[update++]]);
      std::copy_n(product, rows * n, own);
    }
  }
}

void solve(const JointPart& part, auto&& size) {
  JointData& all = part.all;
  for (std::uint32_t k = part.plan.node; k < part.plan.node + part.plan.node_count; ++k) {
    const JointGraph::Node& plan = all.graph.nodes()[k];
    for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
      const JointGraph::Later& to = all.graph.later()[l];
      block::subtract(&all.values[to.block], &all.right[plan.right], size(to.node), size(k),
                      &all.right[to.right]);
    }
  }
  for (std::uint32_t k = part.plan.node + part.plan.node_count; k-- > part.plan.node;) {
    const JointGraph::Node& plan = all.graph.nodes()[k];
    const int n = size(k);
    double x[block::kMaxRows];
    block::times(&all.values[plan.diagonal], &all.right[plan.right], n,
                 plan.joint == JointGraph::kNone ? -1.0 : 1.0, x);
    for (std::uint32_t l = plan.later; l < plan.later + plan.later_count; ++l) {
      const JointGraph::Later& to = all.graph.later()[l];
      block::subtract_transposed(&all.values[to.block], &all.right[to.right], size(to.node), n, x);
    }
    std::copy_n(x, n, &all.right[plan.right]);
  }
}

}  // namespace

void factor(const JointPart& part) {
  if (part.plan.points) {
    factor(part, [](std::uint32_t) { return 3; });
  } else {
    factor(part, [&](std::uint32_t k) { return part.all.nodes[k].n; });
  }
}

void solve(const JointPart& part) {
  if (part.plan.points) {
    solve(part, [](std::uint32_t) { return 3; });
  } else {
    solve(part, [&](std::uint32_t k) { return part.all.nodes[k].n; });
  }
}

}  // namespace tandem::pbd
