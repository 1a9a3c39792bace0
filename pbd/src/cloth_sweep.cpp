// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The solve of a ClothBlock's rows. A translation unit of its own: see cloth_block.cpp.
#include "cloth_sweep.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/corrections.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// By index, without generation check: rows are removed with their bodies.
SolverBody& at(std::span<SolverBody> bodies, BodyId id) { return bodies[id.index]; }
const SolverBody& at(std::span<const SolverBody> bodies, BodyId id) { return bodies[id.index]; }

double length_of(std::span<const SolverBody> bodies, BodyId a, BodyId b) {
  return (at(bodies, b).x - at(bodies, a).x).norm();
}

Vec3 sum_of(std::span<const SolverBody> bodies, const ClothRows& rows,
            const ClothRows::Mean& mean) {
  Vec3 sum = Vec3::Zero();
  for (std::uint32_t i = mean.first; i < mean.first + mean.count; ++i) {
    sum += rows.weights[i] * at(bodies, rows.mean_points[i]).x;
  }
  return sum;
}

Vec3 gap_of(std::span<const SolverBody> bodies, const ClothRows::Attachment& a) {
  const SolverBody& host = at(bodies, a.host);
  return at(bodies, a.particle).x - host.x - rotate(host.q, a.anchor_l);
}

Vec3 three(std::span<const double> values, std::uint32_t from) {
  return {values[from], values[from + 1], values[from + 2]};
}
void put_three(std::span<double> values, std::uint32_t from, const Vec3& value) {
  for (std::uint32_t k = 0; k < 3; ++k) values[from + k] = value[k];
}

}  // namespace

void ClothBlock::Sweep::begin_step(const ClothRows& rows, const SubstepContext& ctx,
                                   std::size_t scalars) {
  lambda_.resize(scalars);
  bounds.resize(scalars);
  offsets_.assign(scalars, 0.0);
  find_groups(rows, ctx.bodies);
  find_points(rows, ctx.bodies.size());
  std::size_t longest = 0;
  for (const ClothRows::Strand& strand : rows.strands) {
    longest = std::max<std::size_t>(longest, strand.count);
  }
  row_.resize(longest);
  link_.resize(longest);
  pulls_.resize(rows.points.size());
  turns_.resize(rows.strands.size());
}

void ClothBlock::Sweep::find_groups(const ClothRows& rows, std::span<const SolverBody> bodies) {
  const auto group_of = [&](BodyId id) { return bodies[id.index].group; };
  strand_group_.resize(rows.strands.size());
  for (std::size_t n = 0; n < rows.strands.size(); ++n) {
    const ClothRows::Strand& strand = rows.strands[n];
    strand_group_[n] = SolverBody::kNoGroup;
    for (std::uint32_t i = 0; i < strand.count; ++i) {
      strand_group_[n] = std::min(strand_group_[n], group_of(rows.points[strand.first + i]));
    }
  }
  tether_group_.resize(rows.tethers.size());
  for (std::size_t n = 0; n < rows.tethers.size(); ++n) {
    tether_group_[n] = std::min(group_of(rows.tethers[n].a), group_of(rows.tethers[n].b));
  }
  mean_group_.resize(rows.means.size());
  for (std::size_t n = 0; n < rows.means.size(); ++n) {
    mean_group_[n] = SolverBody::kNoGroup;
    const ClothRows::Mean& mean = rows.means[n];
    for (std::uint32_t i = mean.first; i < mean.first + mean.count; ++i) {
      mean_group_[n] = std::min(mean_group_[n], group_of(rows.mean_points[i]));
    }
  }
  attachment_group_.resize(rows.attachments.size());
  for (std::size_t n = 0; n < rows.attachments.size(); ++n) {
    const ClothRows::Attachment& a = rows.attachments[n];
    attachment_group_[n] = std::min(group_of(a.particle), group_of(a.host));
  }
}

void ClothBlock::Sweep::find_points(const ClothRows& rows, std::size_t bodies) {
  slots_.clear();
  named_.clear();
  point_of_.assign(bodies, kFree);
  const auto name = [&](BodyId id) {
    std::uint32_t& point = point_of_[id.index];
    if (point == kFree) {
      point = static_cast<std::uint32_t>(slots_.size());
      slots_.push_back(id.index);
    }
    named_.push_back(point);
  };
  for (const BodyId id : rows.points) name(id);
  tethers_at_ = named_.size();
  for (const ClothRows::Tether& tether : rows.tethers) {
    name(tether.a);
    name(tether.b);
  }
  means_at_ = named_.size();
  for (const BodyId id : rows.mean_points) name(id);
  attachments_at_ = named_.size();
  for (const ClothRows::Attachment& a : rows.attachments) name(a.particle);
  points_.resize(slots_.size());
  find_ropes(rows);
  holds_.resize(rows.attachments.size());
  hold_of_.assign(slots_.size(), kFree);
  for (std::uint32_t i = 0; i < rows.attachments.size(); ++i) {
    hold_of_[named_[attachments_at_ + i]] = i;
    holds_[i].host = rows.attachments[i].host.index;
  }
  touched_ = slots_;
  for (const Hold& hold : holds_) {
    if (point_of_[hold.host] != kFree) continue;  // added already: a host is no point
    point_of_[hold.host] = 0;
    touched_.push_back(hold.host);
  }
}

void ClothBlock::Sweep::find_ropes(const ClothRows& rows) {
  rope_.assign(rows.strands.size(), 1);
  strand_of_.assign(slots_.size(), kFree);
  for (std::uint32_t n = 0; n < rows.strands.size(); ++n) {
    const ClothRows::Strand& strand = rows.strands[n];
    for (std::uint32_t i = strand.first; i < strand.first + strand.count; ++i) {
      std::uint32_t& first = strand_of_[named_[i]];
      if (first == kFree) first = n;
      if (first != n) rope_[first] = rope_[n] = 0;
    }
  }
}

void ClothBlock::Sweep::clear_lambdas(const ClothRows& rows, const SubstepContext& ctx) {
  const auto clear = [&](std::uint32_t group, std::uint32_t from, std::uint32_t scalars) {
    if (group == ctx.group) std::fill_n(lambda_.begin() + from, scalars, 0.0);
  };
  for (std::size_t n = 0; n < rows.strands.size(); ++n) {
    clear(strand_group_[n], rows.strands[n].at, rows.strands[n].count - 1);
    if (strand_group_[n] == ctx.group) turns_[n] = 0;
  }
  for (std::size_t n = 0; n < rows.tethers.size(); ++n) {
    clear(tether_group_[n], rows.tethers[n].at, 1);
  }
  for (std::size_t n = 0; n < rows.means.size(); ++n) clear(mean_group_[n], rows.means[n].at, 3);
}

void ClothBlock::Sweep::gather(const SubstepContext& ctx) {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const SolverBody& body = ctx.bodies[slots_[i]];
    if (body.group == ctx.group || body.inv_mass == 0.0) points_[i] = {body.x, body.inv_mass};
  }
}

void ClothBlock::Sweep::scatter(const SubstepContext& ctx) const {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    SolverBody& body = ctx.bodies[slots_[i]];
    if (body.group != ctx.group || body.inv_mass == 0.0) continue;
    body.dx += points_[i].x - body.x;
    body.x = points_[i].x;
  }
}

void ClothBlock::Sweep::refresh_hold(const ClothRows::Attachment& attachment,
                                     std::span<const SolverBody> bodies, Hold& hold) const {
  const SolverBody& host = at(bodies, attachment.host);
  const double own = at(bodies, attachment.particle).inv_mass;
  hold.r = rotate(host.q, attachment.anchor_l);
  if (own == 0.0) {  // immovable
    hold.mobility.setZero();
    hold.share.setZero();
    return;
  }
  const Mat3 its = point_inverse_mass({}, host, Vec3::Zero(), hold.r);
  Mat3 both = its;
  both.diagonal().array() += own;
  hold.share = own * both.inverse();
  hold.mobility = its * hold.share;
}

void ClothBlock::Sweep::push_held(std::span<SolverBody> bodies, std::uint32_t point,
                                  const Vec3& impulse) {
  if (points_[point].inv_mass == 0.0) return;
  const Hold& hold = holds_[hold_of_[point]];
  const Vec3 its = hold.share * impulse;
  points_[point].x += points_[point].inv_mass * (impulse - its);
  apply_correction(bodies[hold.host], its, hold.r.cross(its));
}

void ClothBlock::Sweep::solve_tether(const ClothRows::Tether& tether, std::size_t index,
                                     const SubstepContext& ctx, std::span<const double> held) {
  const std::uint32_t a = named_[tethers_at_ + 2 * index];
  const std::uint32_t b = named_[tethers_at_ + 2 * index + 1];
  const Vec3 d = points_[b].x - points_[a].x;
  const double length = std::sqrt(dot(d, d));
  const double c = length - tether.length - std::max(0.0, held[tether.at]);
  double& lambda = lambda_[tether.at];
  if (!(length > kMinLength) || (c <= 0.0 && lambda == 0.0)) return;
  const Vec3 n = d / length;
  const double w = mobility(a, n, n) + mobility(b, n, n);
  if (!(w > 0.0)) return;
  const double change = std::min(-c / w, -lambda);  // tethers pull only
  lambda += change;
  push(ctx.bodies, a, -change * n);
  push(ctx.bodies, b, change * n);
}

/// @param led  the first point does not move
void ClothBlock::Sweep::solve_mean(const ClothRows& rows, const ClothRows::Mean& mean,
                                   const SubstepContext& ctx, std::span<const double> held,
                                   bool led) {
  const std::uint32_t* const named = named_.data() + means_at_ + mean.first;
  const double* const weights = rows.weights.data() + mean.first;
  const std::uint32_t first = led ? 1 : 0;
  const double soft = mean.compliance / (ctx.h * ctx.h);
  Vec3 c = -Vec3(held[mean.at], held[mean.at + 1], held[mean.at + 2]);
  double stiff = 0.0;
  bool rigid = false;
  for (std::uint32_t i = 0; i < mean.count; ++i) {
    const Point& point = points_[named[i]];
    c += weights[i] * point.x;
    if (i < first) continue;
    rigid = rigid || hold_of_[named[i]] != kFree;
    stiff += weights[i] * weights[i] * point.inv_mass;
  }
  if (!(stiff > 0.0)) return;
  double* const lambda = lambda_.data() + mean.at;
  Vec3 change = -(c + soft * Vec3(lambda[0], lambda[1], lambda[2]));
  if (rigid) {
    Mat3 k = Mat3::Identity() * (soft + kRegular * stiff);
    for (std::uint32_t i = first; i < mean.count; ++i) {
      const std::uint32_t hold = hold_of_[named[i]];
      const double w2 = weights[i] * weights[i];
      if (hold == kFree) {
        k.diagonal().array() += w2 * points_[named[i]].inv_mass;
      } else {
        k += w2 * holds_[hold].mobility;
      }
    }
    change = k.inverse() * change;
  } else {
    change *= 1.0 / (stiff + soft);
  }
  for (int k = 0; k < 3; ++k) lambda[k] += change[k];
  for (std::uint32_t i = first; i < mean.count; ++i) {
    push(ctx.bodies, named[i], weights[i] * change);
  }
}

void ClothBlock::Sweep::solve_attachment(const ClothRows& rows, std::size_t index,
                                         const SubstepContext& ctx, std::span<const double> held) {
  const ClothRows::Attachment& a = rows.attachments[index];
  Point& particle = points_[named_[attachments_at_ + index]];
  SolverBody& host = at(ctx.bodies, a.host);
  const Vec3 r = rotate(host.q, a.anchor_l);
  Mat3 k = point_inverse_mass({}, host, Vec3::Zero(), r);
  k.diagonal().array() += particle.inv_mass;
  if (k.diagonal().maxCoeff() > 0.0) {
    const Vec3 kept(held[a.at], held[a.at + 1], held[a.at + 2]);
    const Vec3 c = particle.x - host.x - r - kept;
    const Vec3 impulse = -(k.inverse() * c);
    particle.x += particle.inv_mass * impulse;
    apply_correction(host, -impulse, -r.cross(impulse));
  }
  refresh_hold(a, ctx.bodies, holds_[index]);
}

void ClothBlock::Sweep::run(const ClothRows& rows, const SubstepContext& ctx,
                            std::span<const double> held, int sweeps, bool led) {
  gather(ctx);
  bool reverse = ctx.reverse;
  const auto sweep = [&](std::span<const std::uint32_t> groups, const auto& solve) {
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::size_t n = reverse ? groups.size() - 1 - k : k;
      if (groups[n] == ctx.group) solve(n);
    }
  };
  for (int i = 0; i < sweeps; ++i, reverse = !reverse) {
    sweep(attachment_group_, [&](std::size_t n) { solve_attachment(rows, n, ctx, held); });
    sweep(mean_group_, [&](std::size_t n) {
      solve_mean(rows, rows.means[n], ctx, held, led && rows.means[n].leads);
    });
    sweep(tether_group_, [&](std::size_t n) { solve_tether(rows.tethers[n], n, ctx, held); });
    sweep(strand_group_, [&](std::size_t n) { solve_strand(rows, n, ctx, held); });
  }
  scatter(ctx);
}

void ClothBlock::Sweep::violations(const ClothRows& rows, std::span<const SolverBody> bodies,
                                   std::uint32_t group, std::span<double> out) const {
  for (std::size_t n = 0; n < rows.strands.size(); ++n) {
    if (!in_group(strand_group_[n], group)) continue;
    const ClothRows::Strand& strand = rows.strands[n];
    for (std::uint32_t i = 0; i + 1 < strand.count; ++i) {
      const std::uint32_t k = strand.first + i;
      out[strand.at + i] = length_of(bodies, rows.points[k], rows.points[k + 1]) - rows.lengths[k];
    }
  }
  for (std::size_t n = 0; n < rows.tethers.size(); ++n) {
    if (!in_group(tether_group_[n], group)) continue;
    const ClothRows::Tether& tether = rows.tethers[n];
    out[tether.at] = length_of(bodies, tether.a, tether.b) - tether.length;
  }
  for (std::size_t n = 0; n < rows.means.size(); ++n) {
    if (!in_group(mean_group_[n], group)) continue;
    put_three(out, rows.means[n].at, sum_of(bodies, rows, rows.means[n]));
  }
  for (std::size_t n = 0; n < rows.attachments.size(); ++n) {
    if (!in_group(attachment_group_[n], group)) continue;
    put_three(out, rows.attachments[n].at, gap_of(bodies, rows.attachments[n]));
  }
}

void ClothBlock::Sweep::follow(const ClothRows& rows, const SubstepContext& ctx) {
  for (std::size_t n = 0; n < rows.means.size(); ++n) {
    const ClothRows::Mean& mean = rows.means[n];
    if (!mean.leads || mean_group_[n] != ctx.group) continue;
    at(ctx.bodies, rows.mean_points[mean.first]).x -=
        (sum_of(ctx.bodies, rows, mean) - three(bounds, mean.at)) / rows.weights[mean.first];
  }
}

}  // namespace tandem::pbd
