// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_refinement.h"

#include <algorithm>
#include <cmath>

#include "contact_gravity.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {
namespace {

/// An island whose contacts carry n times the weight of the lighter body (rms: a tall stack, a
/// heavy body on a light one) wants this many times n substeps. A body of size r wants substeps
/// shorter than this share of the time in which it topples, sqrt(r / g): otherwise pebbles of a
/// millimetre rock, and at a share of 0.08 a pyramid of 5 cm boxes falls in 8 s. Limited to
/// kMaxSubsteps.
constexpr double kSubstepsPerLoad = 1.0 / 11.0;
constexpr double kFallShare = 0.05;
constexpr double kMaxSubsteps = 32.0;
/// m/s, rms: a faster island does not stand. An impact is no load, and only standing bodies can
/// fall over.
constexpr double kStanding = 0.5;

/// Contacts per chunk of a worker.
constexpr std::size_t kShareGrain = 256;

/// Rounds to the solver's substeps times a power of two.
int rounded_up(double wanted, int least) {
  int substeps = least;
  while (substeps < wanted) substeps *= 2;
  return substeps;
}

}  // namespace

ContactRefinement::Share ContactRefinement::share_of(const Contact& contact,
                                                     const SubstepContext& ctx) {
  const double gravity = gravity_of(ctx);
  const double topples = ctx.gravity.norm();  // zero for floating bodies, which do not topple
  const std::uint32_t a = contact.manifold.body_a;
  const std::uint32_t b = contact.manifold.body_b;
  const std::uint32_t movable = ctx.bodies[a].inv_mass > 0.0 ? a : b;
  const SolverBody& body = ctx.bodies[movable];
  if (body.group == SolverBody::kNoGroup) return {.island = BodyId::kNone};
  const double lightness = std::max(ctx.bodies[a].inv_mass, ctx.bodies[b].inv_mass);
  const double load = contact.impulse / ctx.h;  // N, mean of the step
  Share share{.island = body.island,
              .ratio2 = load * load * lightness * lightness / (gravity * gravity)};
  // A body that cannot turn does not topple.
  if (!body.turns_freely && body.inv_inertia_w.isZero(0.0)) return share;
  const ManifoldPoint& point = contact.manifold.points[0];
  const double arm = movable == a ? point.anchor_a_l.norm() + contact.manifold.radius_a
                                  : point.anchor_b_l.norm() + contact.manifold.radius_b;
  share.for_size = ctx.h / (kFallShare * std::sqrt(arm / topples));
  return share;
}

int ContactRefinement::want(std::span<const Contact> contacts,
                            std::span<const std::uint32_t> sequence, int budget,
                            const SubstepContext& ctx, std::span<double> wanted) {
  loads_.resize(ctx.bodies.size());
  for (const std::uint32_t i : ctx.movers) loads_[i] = {};
  const std::size_t places = ctx.order.natural() ? ctx.movers.size() : ctx.bodies.size();
  for (std::uint32_t n = 0; n < places; ++n) {
    const SolverBody& body = ctx.bodies[ctx.order.natural() ? ctx.movers[n] : ctx.order.slot(n)];
    if (!body.is_solved()) continue;
    Load& island = loads_[body.island];
    island.speed2 += body.v.squaredNorm();
    ++island.bodies;
  }
  shares_.resize(contacts.size());
  ctx.workers->for_chunks(contacts.size(), kShareGrain,
                          [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t k = begin; k < end; ++k)
                              shares_[k] = share_of(contacts[k], ctx);
                          });
  for (std::size_t n = 0; n < contacts.size(); ++n) {
    const Share& share = shares_[sequence.empty() ? n : sequence[n]];
    if (share.island == BodyId::kNone) continue;
    Load& island = loads_[share.island];
    ++island.contacts;
    island.ratio2 += share.ratio2;
    island.for_size = std::max(island.for_size, share.for_size);
  }
  double asked = 0.0;  // rows of all further substeps
  for (const std::uint32_t i : ctx.movers) {
    Load& island = loads_[i];
    if (island.contacts == 0 || island.speed2 > kStanding * kStanding * island.bodies) continue;
    island.wanted =
        std::max(island.for_size, kSubstepsPerLoad * std::sqrt(island.ratio2 / island.contacts));
    island.wanted = rounded_up(std::min(kMaxSubsteps, island.wanted), ctx.substeps);
    asked += island.contacts * (island.wanted - ctx.substeps);
  }
  // If they exceed the budget, each gets the same share, rounded down.
  const double share = std::min(1.0, budget / std::max(1.0, asked));
  double given = 0.0;
  for (const std::uint32_t i : ctx.movers) {
    if (!(loads_[i].wanted > ctx.substeps)) continue;
    const double most = ctx.substeps + share * (loads_[i].wanted - ctx.substeps);
    int substeps = ctx.substeps;
    while (2 * substeps <= most) substeps *= 2;
    given += loads_[i].contacts * (substeps - ctx.substeps);
    wanted[i] = std::max(wanted[i], static_cast<double>(substeps));
  }
  return static_cast<int>(asked - given);
}

}  // namespace tandem::pbd
