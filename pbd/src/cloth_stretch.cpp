// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Recovery of threads that a stronger constraint has stretched. A translation unit of its own: see
// cloth_block.cpp.
#include <algorithm>
#include <cmath>

#include "cloth_sweep.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Beyond this strain a stronger constraint has stretched or compressed a thread.
constexpr double kStretched = 0.01;

}  // namespace

bool ClothBlock::Sweep::hold_stretched(const ClothRows& rows, const SubstepContext& ctx,
                                       std::span<const double> carried) {
  std::copy(carried.begin(), carried.end(), offsets_.begin());
  bool far = false;
  for (std::size_t n = 0; n < rows.strands.size(); ++n) {
    const ClothRows::Strand& strand = rows.strands[n];
    if (strand_group_[n] != ctx.group) continue;
    for (std::uint32_t i = 0; i + 1 < strand.count; ++i) {
      const std::uint32_t k = strand.at + i;
      const double c = bounds[k] - carried[k];
      const double most = kStretched * rows.lengths[strand.first + i];
      if (std::abs(c) <= most) continue;
      far = far || strand.compliance == 0.0;
      offsets_[k] += c;
    }
  }
  for (std::size_t n = 0; far && n < rows.means.size(); ++n) {
    if (mean_group_[n] != ctx.group || rows.means[n].compliance == 0.0) continue;
    const std::uint32_t at = rows.means[n].at;
    for (std::uint32_t k = at; k < at + 3; ++k) offsets_[k] = bounds[k];
  }
  return far;
}

void ClothBlock::Sweep::remember(const SubstepContext& ctx) {
  stretched_.start.resize(touched_.size());
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    stretched_.start[i] = ctx.bodies[touched_[i]];
  }
}

void ClothBlock::Sweep::moves_since(const SubstepContext& ctx, std::vector<Moved>& moves) const {
  moves.resize(touched_.size());
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const SolverBody& body = ctx.bodies[touched_[i]];
    const SolverBody& start = stretched_.start[i];
    moves[i] = {body.dx - start.dx, body.dtheta - start.dtheta};
  }
}

void ClothBlock::Sweep::move_from_start(const SubstepContext& ctx,
                                        std::span<const Moved> moves) const {
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    SolverBody& body = ctx.bodies[touched_[i]];
    const SolverBody& start = stretched_.start[i];
    if (body.group != ctx.group || body.inv_mass == 0.0) continue;
    const Moved moved = moves.empty() ? Moved{} : moves[i];
    body.x = start.x + moved.x;
    body.dx = start.dx + moved.x;
    body.dtheta = start.dtheta + moved.turn;
    body.q = moved.turn.isZero(0.0) ? start.q : rotated(start.q, moved.turn);
  }
}

/// Kinetic energy is quadratic in the share s of the way from passive to full moves: E(s) = E(0) +
/// b s + a s^2, in units of m^2 kg / h^2.
double ClothBlock::Sweep::affordable(const SubstepContext& ctx) const {
  double before = 0.0, passive = 0.0, a = 0.0, b = 0.0;
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const SolverBody& start = stretched_.start[i];
    if (start.group != ctx.group || start.inv_mass == 0.0) continue;
    const auto add = [&](const Vec3& moves, const Vec3& by, const Vec3& on, const auto& inertia) {
      const Vec3 calm = moves + by, more = on - by;
      before += moves.dot(inertia * moves);
      passive += calm.dot(inertia * calm);
      b += 2.0 * calm.dot(inertia * more);
      a += more.dot(inertia * more);
    };
    const double mass = 1.0 / start.inv_mass;
    add(ctx.h * start.v + start.dx, stretched_.passive[i].x, stretched_.full[i].x,
        mass * Mat3::Identity());
    add(ctx.h * start.w + start.dtheta, stretched_.passive[i].turn, stretched_.full[i].turn,
        inverse_where_free(start.inv_inertia_w));
  }
  const double left = std::max(0.0, before - passive);
  if (!(a > 0.0)) return 0.0;
  // The larger root of a s^2 + b s - left = 0.
  const double s = (-b + std::sqrt(b * b + 4.0 * a * left)) / (2.0 * a);
  return std::isfinite(s) ? std::clamp(s, 0.0, 1.0) : 0.0;
}

void ClothBlock::Sweep::run_real(const ClothRows& rows, const SubstepContext& ctx,
                                 std::span<const double> carried, int sweeps) {
  if (!hold_stretched(rows, ctx, carried)) return run(rows, ctx, carried, sweeps, false);
  remember(ctx);
  run(rows, ctx, offsets_, sweeps, false);
  moves_since(ctx, stretched_.passive);
  move_from_start(ctx, {});
  clear_lambdas(rows, ctx);
  run(rows, ctx, carried, sweeps, false);
  moves_since(ctx, stretched_.full);
  const double share = affordable(ctx);
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const Moved& passive = stretched_.passive[i];
    Moved& moved = stretched_.full[i];
    moved = {passive.x + share * (moved.x - passive.x),
             passive.turn + share * (moved.turn - passive.turn)};
  }
  move_from_start(ctx, stretched_.full);
  violations(rows, ctx.bodies, ctx.group, bounds);  // kept by joints that iterate on
}

}  // namespace tandem::pbd
