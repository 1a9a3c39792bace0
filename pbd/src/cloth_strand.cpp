// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The direct solve of a strand. A translation unit of its own: see cloth_block.cpp.
#include <algorithm>
#include <cmath>

#include "cloth_sweep.h"
#include "joint_algebra.h"
#include "tandem/pbd/corrections.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Share of the mass that hangs on a link: a slack link resists turning by this much, which keeps
/// its compliance finite.
constexpr double kSlack = 1e-6;
/// Largest (rate h)^2 of a strand's fastest swing for which links may pull along their free
/// directions: beyond 2.2 the swing grows.
constexpr double kResolved = 1.0;
/// Strain beyond which Newton's method does not start: of 200 ropes that a ball hits, 31 gain
/// energy without bound.
constexpr double kFar = 0.05;
/// Tolerance as a share of a link's length, and the limit of Newton iterations. With two
/// iterations, a rope of 61 particles and 1 m under 1000 kg tears.
constexpr double kClose = 1e-5;
constexpr int kMaxRounds = 10;

}  // namespace

void ClothBlock::Sweep::solve_straight(const ClothRows& rows, const ClothRows::Strand& strand,
                                       double softness, std::span<const double> held) {
  const std::uint32_t count = strand.count - 1;
  const std::uint32_t* const named = named_.data() + strand.first;
  const double* const lengths = rows.lengths.data() + strand.first;
  for (std::uint32_t i = 0; i < count; ++i) {
    Row& row = row_[i];
    const Vec3 d = points_[named[i + 1]].x - points_[named[i]].x;
    const double length = std::sqrt(dot(d, d));
    row.n = length > kMinLength ? Vec3(d * (1.0 / length)) : Vec3(Vec3::Zero());
    const double stiff = mobility(named[i], row.n, row.n) + mobility(named[i + 1], row.n, row.n);
    const double soft = softness * lengths[i];
    row.rhs = lengths[i] + held[strand.at + i] - length - soft * lambda_[strand.at + i];
    row.diagonal = (1.0 + kRegular) * stiff + soft;
    if (!(stiff > 0.0)) {  // rigid and immovable, or without direction
      row.rhs = 0.0;
      row.diagonal = 1.0;
    }
    row.next = 0.0;
    if (i > 0) row_[i - 1].next = -mobility(named[i], row_[i - 1].n, row.n);
  }
  // The matrix is J M^-1 J^T + at: tridiagonal, positive definite.
  for (std::uint32_t i = 1; i < count; ++i) {
    const double factor = row_[i - 1].next / row_[i - 1].diagonal;
    row_[i].diagonal -= factor * row_[i - 1].next;
    row_[i].rhs -= factor * row_[i - 1].rhs;
  }
  row_[count - 1].rhs /= row_[count - 1].diagonal;
  for (std::uint32_t i = count - 1; i > 0; --i) {
    row_[i - 1].rhs = (row_[i - 1].rhs - row_[i - 1].next * row_[i].rhs) / row_[i - 1].diagonal;
  }
}

bool ClothBlock::Sweep::swings_fast(const ClothRows& rows, const ClothRows::Strand& strand) const {
  const std::uint32_t* const named = named_.data() + strand.first;
  bool fast = false;
  for (std::uint32_t i = 0; i + 1 < strand.count; ++i) {
    const double length = rows.lengths[strand.first + i];
    const Vec3 d = points_[named[i + 1]].x - points_[named[i]].x;
    if (std::abs(std::sqrt(dot(d, d)) - length) > kFar * length) return false;
    const double give = mobility_trace(named[i]) + mobility_trace(named[i + 1]);
    const double pull = -(lambda_[strand.at + i] + row_[i].rhs);
    fast = fast || 2.0 * pull * give > 3.0 * kResolved * length;
  }
  return fast;
}

/// A link under tension T that ends along n, at length l, pulls its ends along its direction at the
/// end: T n + (T / l) (1 - n n^T) g, where g is the relative motion of the ends. This is Newton's
/// method for the pose nearest to the predicted one in which all links have their lengths. That
/// pose makes it stable at any tension.
/// With p the impulse of each link, w mobilities, and L = at n n^T + (l / T) (1 - n n^T):
/// (L_i + w_i + w_i+1) dp_i - w_i dp_i-1 - w_i+1 dp_i+1 = -e_i, 3 x 3 blocks.
double ClothBlock::Sweep::solve_turning(const ClothRows& rows, const ClothRows::Strand& strand,
                                        double softness, std::span<const double> held) {
  const std::uint32_t count = strand.count - 1;
  const std::uint32_t* const named = named_.data() + strand.first;
  const double* const lengths = rows.lengths.data() + strand.first;
  double off = 0.0;
  const auto add_mobility = [&](Mat3& k, std::uint32_t point, double share) {
    const std::uint32_t hold = hold_of_[point];
    if (hold == kFree) {
      k.diagonal().array() += share * points_[point].inv_mass;
    } else {
      k += share * holds_[hold].mobility;
    }
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    Link& link = link_[i];
    const Vec3& pull = pulls_[strand.first + i];
    const Vec3 d = points_[named[i + 1]].x - points_[named[i]].x;
    const double length = std::sqrt(dot(d, d));
    const Vec3 n = length > kMinLength ? Vec3(d * (1.0 / length)) : Vec3(Vec3::Zero());
    const double give = mobility_trace(named[i]) + mobility_trace(named[i + 1]);
    Mat3& k = link.inverse;
    k.setZero();
    link.rhs.setZero();
    if (!(give > 0.0)) {
      k.setIdentity();
      continue;
    }
    const double along = dot(n, pull);
    const double tension = -lambda_[strand.at + i];
    const double turns = 1.0 / std::max(tension / std::max(length, kMinLength), kSlack / give);
    const double soft = softness * lengths[i];
    const double missing = length - lengths[i] - held[strand.at + i] - soft * along;
    off = std::max(off, std::abs(missing) / lengths[i]);
    link.rhs = missing * n - turns * (pull - along * n);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) k(r, c) = (soft - turns) * n[r] * n[c];
    }
    k.diagonal().array() += turns;
    add_mobility(k, named[i], 1.0 + kRegular);
    add_mobility(k, named[i + 1], 1.0 + kRegular);
    if (i > 0) {
      const std::uint32_t hold = hold_of_[named[i]];
      const Mat3& before = link_[i - 1].inverse;
      if (hold == kFree) {
        const double w = points_[named[i]].inv_mass;
        k -= (w * w) * before;
      } else {
        k -= holds_[hold].mobility * before * holds_[hold].mobility;
      }
      link.rhs += moved(named[i], block::times(before, link_[i - 1].rhs));
    }
    block::invert(k);
  }
  Vec3 after = Vec3::Zero();
  for (std::uint32_t i = count; i-- > 0;) {
    Link& link = link_[i];
    after = block::times(link.inverse, link.rhs + moved(named[i + 1], after));
    link.rhs = after;
  }
  return off;
}

void ClothBlock::Sweep::solve_strand(const ClothRows& rows, std::size_t index,
                                     const SubstepContext& ctx, std::span<const double> held) {
  const ClothRows::Strand& strand = rows.strands[index];
  const std::uint32_t count = strand.count - 1;
  const std::uint32_t* const named = named_.data() + strand.first;
  const double softness = strand.compliance / (ctx.h * ctx.h);
  const auto pull_all = [&](const auto& pull_of) {
    Vec3 before = Vec3::Zero();
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3 pull = pull_of(i);
      push(ctx.bodies, named[i], pull - before);
      before = pull;
    }
    push(ctx.bodies, named[count], -before);
  };
  if (turns_[index] == 0) {
    solve_straight(rows, strand, softness, held);
    turns_[index] = rope_[index] != 0 && swings_fast(rows, strand) ? 1 : 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      pulls_[strand.first + i] = -lambda_[strand.at + i] * row_[i].n;
      lambda_[strand.at + i] += row_[i].rhs;
    }
    if (turns_[index] == 0) {
      pull_all([&](std::uint32_t i) { return Vec3(-row_[i].rhs * row_[i].n); });
      return;
    }
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    const double off = solve_turning(rows, strand, softness, held);
    pull_all([&](std::uint32_t i) { return link_[i].rhs; });
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3 d = points_[named[i + 1]].x - points_[named[i]].x;
      const double length = std::sqrt(dot(d, d));
      Vec3& pull = pulls_[strand.first + i];
      pull += link_[i].rhs;
      lambda_[strand.at + i] = length > kMinLength ? -dot(d, pull) / length : 0.0;
    }
    if (off <= kClose) break;
  }
}

}  // namespace tandem::pbd
