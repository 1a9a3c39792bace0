// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "seam.h"

#include <algorithm>
#include <limits>

namespace tandem::mpi {

using pbd::SolverBody;
using pbd::SubstepContext;
using pbd::Vec3;

namespace {

/// Iterations in which ranks solve displacements against contacts, those between them and their
/// own.
constexpr int kHoldTurns = 4;

}  // namespace

template <class Visit>
void Seam::for_touched(const Neighbour& neighbour, const SubstepContext& ctx, Visit&& visit) {
  for (const std::uint32_t slot : neighbour.touched) {
    if (ctx.bodies[slot].group == ctx.group) visit(slot);
  }
}

std::size_t Seam::part_of(const Neighbour& neighbour, const SubstepContext& ctx) {
  const auto in_group = [&](std::uint32_t slot) { return ctx.bodies[slot].group == ctx.group; };
  return static_cast<std::size_t>(
      std::count_if(neighbour.touched.begin(), neighbour.touched.end(), in_group));
}

void Seam::forget() { rows_.assign(pbd::ContactBlock()); }

void Seam::note_touched(std::span<const pbd::Manifold> between, std::uint32_t slots) {
  touched_.assign(slots, 0);
  for (const pbd::Manifold& m : between) touched_[m.body_a] = touched_[m.body_b] = 1;
  for (Neighbour& neighbour : neighbours_.all()) {
    if (!neighbour.solves) continue;
    for (const std::uint32_t slot : neighbour.bodies) {
      if (touched_[slot] != 0) neighbour.touched.push_back(slot);
    }
  }
}

void Seam::begin_step(const SubstepContext& ctx) {
  if (!rows_.empty()) rows_.begin_step(ctx);
  // Displaced bodies press on other ranks' bodies, which then take part: each neighbour needs to
  // know whether one of the two has targets in this step, or a rank beyond them, as far as pressure
  // spreads in this number of iterations.
  displaces_ = ctx.shared;
  for (int turn = 0; turn < kHoldTurns; ++turn) {
    const bool own = displaces_;
    for (const Neighbour& neighbour : neighbours_.all()) {
      if (neighbour.touched.empty()) continue;
      MessageWriter(ranks_.outgoing()).put(static_cast<std::uint8_t>(own));
      ranks_.send(neighbour.rank, Topic::Targets);
    }
    for (Neighbour& neighbour : neighbours_.all()) {
      neighbour.displaces = false;
      if (neighbour.touched.empty()) continue;
      const bool theirs = ranks_.receive(neighbour.rank, Topic::Targets).get<std::uint8_t>() != 0;
      neighbour.displaces = own || theirs;
      displaces_ = displaces_ || theirs;
    }
  }
  displaces_ = false;
  for (const Neighbour& neighbour : neighbours_.all()) {
    if (!neighbour.displaces) continue;
    displaces_ = true;
    for (const std::uint32_t slot : neighbour.touched)
      ctx.bodies[slot].shared = ctx.bodies[slot].held = true;
  }
}

void Seam::begin_substep(const SubstepContext& ctx) {
  if (!rows_.empty()) rows_.begin_substep(ctx);
}

void Seam::warm_start(const SubstepContext& ctx) {
  remember(ctx);
  if (!rows_.empty()) rows_.warm_start(ctx);
  exchange_corrections(ctx, Topic::WarmStart, false);
}

double Seam::project(const SubstepContext& ctx) {
  exchange_velocities(ctx, false);
  remember(ctx);
  const double moved = rows_.empty() ? 0.0 : rows_.project(ctx);
  exchange_corrections(ctx, Topic::Corrections, true);
  return moved;
}

double Seam::project_displacement(const SubstepContext& ctx) {
  for (int turn = 0; turn < kHoldTurns; ++turn) {
    exchange_velocities(ctx, false, With::WhoDisplaces);
    remember(ctx, With::WhoDisplaces);
    if (!rows_.empty()) rows_.project_displacement(ctx);
    exchange_corrections(ctx, Topic::Corrections, true, With::WhoDisplaces);
    // Displaced bodies press on the next ones.
    for (const auto& block : world_.blocks()) {
      if (block.get() == world_.contacts() && !block->empty()) block->project_displacement(ctx);
    }
  }
  return 0.0;
}

double Seam::solve_velocity(const SubstepContext& ctx) {
  exchange_velocities(ctx, true);
  remember(ctx);
  if (!rows_.empty()) rows_.solve_velocity(ctx);
  exchange_corrections(ctx, Topic::Corrections, false);
  // The ranks do not know whether the others have converged: all take the same number of sweeps.
  return std::numeric_limits<double>::infinity();
}

void Seam::finish_velocity(const SubstepContext& ctx) {
  if (!rows_.empty()) rows_.finish_velocity(ctx);
}

void Seam::end_step(const SubstepContext& ctx, std::span<double> wanted) {
  neighbours_.note_motion(ctx.bodies);
  if (!rows_.empty()) rows_.end_step(ctx, wanted);
}

pbd::BlockReport Seam::report() const {
  pbd::BlockReport report = rows_.report();
  report.name = name();
  return report;
}

/// From the owners to the solving rank.
void Seam::exchange_velocities(const SubstepContext& ctx, bool with_pose, With with) {
  for (const Neighbour& neighbour : neighbours_.all()) {
    const std::size_t count = part_of(neighbour, ctx);
    if (neighbour.solves || count == 0 || !neighbour.takes_part(with)) continue;
    DoubleWriter out(MessageWriter(ranks_.outgoing()).room(count * (with_pose ? 13 : 12)));
    for_touched(neighbour, ctx, [&](std::uint32_t slot) {
      const SolverBody& body = ctx.bodies[slot];
      out.vec3(body.v);
      out.vec3(body.w);
      if (with_pose) {
        out.vec3(body.x);
        out.quat(body.q);
        return;
      }
      out.vec3(body.v_push);
      out.vec3(body.w_push);
    });
    ranks_.send(neighbour.rank, Topic::Velocities);
  }
  for (const Neighbour& neighbour : neighbours_.all()) {
    if (!neighbour.solves || part_of(neighbour, ctx) == 0 || !neighbour.takes_part(with)) continue;
    MessageReader in = ranks_.receive(neighbour.rank, Topic::Velocities);
    for_touched(neighbour, ctx, [&](std::uint32_t slot) {
      SolverBody& body = ctx.bodies[slot];
      body.v = in.vec3();
      body.w = in.vec3();
      if (with_pose) {
        body.x = in.vec3();
        body.q = in.quat();
        return;
      }
      body.v_push = in.vec3();
      body.w_push = in.vec3();
    });
    if (in.failed() || in.remaining() > 0) Environment::abort("ranks disagree on what touches");
  }
}

void Seam::remember(const SubstepContext& ctx, With with) {
  before_.clear();
  for (const Neighbour& neighbour : neighbours_.all()) {
    if (!neighbour.solves || !neighbour.takes_part(with)) continue;
    for_touched(neighbour, ctx, [&](std::uint32_t slot) {
      const SolverBody& body = ctx.bodies[slot];
      before_.push_back({body.v, body.w, body.v_push, body.w_push});
    });
  }
}

/// From the solving rank back to the owners: changes since remember().
void Seam::exchange_corrections(const SubstepContext& ctx, Topic topic, bool with_push, With with) {
  std::size_t at = 0;
  for (const Neighbour& neighbour : neighbours_.all()) {
    const std::size_t count = part_of(neighbour, ctx);
    if (!neighbour.solves || count == 0 || !neighbour.takes_part(with)) continue;
    DoubleWriter out(MessageWriter(ranks_.outgoing()).room(count * (with_push ? 12 : 6)));
    for_touched(neighbour, ctx, [&](std::uint32_t slot) {
      const SolverBody& body = ctx.bodies[slot];
      const Motion& before = before_[at++];
      out.vec3(body.v - before.v);
      out.vec3(body.w - before.w);
      if (!with_push) return;
      out.vec3(body.v_push - before.v_push);
      out.vec3(body.w_push - before.w_push);
    });
    ranks_.send(neighbour.rank, topic);
  }
  for (const Neighbour& neighbour : neighbours_.all()) {
    if (neighbour.solves || part_of(neighbour, ctx) == 0 || !neighbour.takes_part(with)) continue;
    MessageReader in = ranks_.receive(neighbour.rank, topic);
    for_touched(neighbour, ctx, [&](std::uint32_t slot) {
      SolverBody& body = ctx.bodies[slot];
      body.v += in.vec3();
      body.w += in.vec3();
      if (!with_push) return;
      body.v_push += in.vec3();
      body.w_push += in.vec3();
    });
    if (in.failed() || in.remaining() > 0) Environment::abort("ranks disagree on what touches");
  }
}

}  // namespace tandem::mpi
