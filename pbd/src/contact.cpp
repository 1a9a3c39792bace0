// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact_gravity.h"
#include "contact_impl.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

/// Overlap that is left alone, so that resting contacts stay, as a share of twice the distance that
/// a body falls from rest within a substep. Every other substep opens deep overlaps only. This
/// leaves no more than opening all each time (katamari 0.07 mm in the mean, cliff 0.01 mm); opening
/// none leaves boxes that start 0.3 m deep there twice as long and lets through bars of a tower
/// that is dropped 2 cm into each other.
constexpr double kPushSlop = 0.05;
constexpr double kPushSlopBetween = 1.0;

/// The share for this substep.
double push_slop(const SubstepContext& ctx) {
  return ctx.last || ctx.substep % 2 == 1 ? kPushSlop : kPushSlopBetween;
}

/// Sweeps that hold displacements against contacts. With one, a light body pulled by its target
/// under a heavy one is pressed into the ground: pile, profile 5, seeds 831 to 834: three of four
/// runs lost a cube through it, deepest overlap 73 to 94 mm; with four none did, 37 to 65 mm.
constexpr int kHoldSweeps = 4;

/// m, lever arm that converts rad/s to m/s where one speed is needed.
constexpr double kLeverArm = 0.1;

/// Bodies that close a joint's gap leave overlaps slowly. After an impact has left a limb on the
/// wrong side of something, contacts and the joint want it in two places, and pushed at full speed
/// it oscillates between them: in five heaps of 27 ragdolls 17 to 76 bodies trembled after 8 s, at
/// up to 1.1 m/s, with joints open by 9 mm to 1 m; now at most 2 do, with joints open by at most
/// 0.3 mm (p99). At 0.02 m/s three of
/// fifteen dolls that fall on a floor do not sleep after 6 s; at 0 overlaps stay.
void yield_to_gaps(const SubstepContext& ctx) {
  constexpr double kSlow = 0.005;  // m/s
  for (const std::uint32_t i : ctx.members) {
    SolverBody& body = ctx.bodies[i];
    if (!body.shared || body.held) continue;
    const double fast = std::max(body.v_push.norm(), kLeverArm * body.w_push.norm());
    if (fast <= kSlow) continue;
    body.v_push *= kSlow / fast;
    body.w_push *= kSlow / fast;
  }
}

/// Updates a contact at the end of a step.
void finish_contact(Contact& contact, std::span<const SolverBody> bodies, double& worst) {
  const Manifold& m = contact.manifold;
  const SolverBody& a = bodies[m.body_a];
  const SolverBody& b = bodies[m.body_b];
  const bool asleep = a.group == SolverBody::kNoGroup && b.group == SolverBody::kNoGroup;
  if (!asleep || contact.overlap < 0.0) {  // sleeping contacts keep theirs
    contact.overlap = 0.0;
    for (int i = 0; i < m.count; ++i) {
      contact.overlap = std::max(contact.overlap, -gap_of(m, a, b, i));
    }
  }
  worst = std::max(worst, contact.overlap);
}

}  // namespace

ContactBlock::ContactBlock() : impl_(std::make_unique<Impl>()) {}
ContactBlock::~ContactBlock() = default;

std::span<const Contact> ContactBlock::contacts() const { return impl_->kept(); }
std::span<const ContactBrief> ContactBlock::briefs() const { return impl_->briefs(); }
bool ContactBlock::any_friction() const { return impl_->any_friction; }
bool ContactBlock::any_restitution() const { return impl_->any_restitution; }
bool ContactBlock::empty() const { return impl_->kept().empty(); }

void ContactBlock::configure(const ContactOptions& options) {
  impl_->options = options;
  impl_->kernels = &contact_kernels(options.lanes);
}

void ContactBlock::begin_step(const SubstepContext& ctx) {
  Impl& m = *impl_;
  m.forget_loads(ctx);
  m.put_in_sequence();
  const auto arranged = m.support.arrange(m.briefs(), m.sequence, ctx.bodies, ctx.movers);
  m.statics.guess(m.contacts, arranged, m.support, ctx.bodies, ctx.movers, ctx.gravity,
                  m.options.warm_start_gap, ctx.h);
  m.cells.find(arranged, ctx);
  const auto team = static_cast<std::size_t>(ctx.workers->count());
  m.order.build(arranged, m.cells, ctx.bodies.size(), ctx.movers, static_cast<std::uint32_t>(team));
  m.count_levels(ctx.groups);
  if (team > m.groups.size()) m.groups.resize(team);
  const std::size_t most = m.most_blocks_at_once(ctx.groups);
  for (ContactGroup& group : m.groups) {
    group.reserve(most, ctx.bodies.size(), m.any_restitution);
    group.extra_rows = group.refined_rows = group.open_rows = 0;
  }
  m.pushed.resize(ctx.bodies.size());
  m.refused_rows = 0;
  m.least_substeps = ctx.substeps;
}

void ContactBlock::Impl::make_rows(const SubstepContext& ctx) {
  const auto places = order.places(ctx.group);
  const std::size_t blocks = places.size() / kLanes;
  ContactGroup& own = group(ctx);
  own.make_room(blocks);
  // Reserved memory is not touched before it is written to.
  if (blocks > own.room.size()) own.room.resize(blocks);
  own.rows = std::span(own.room).first(blocks);
  const std::span<ContactRows> rows = own.rows;
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  const auto prepare = [&](ContactRows& made, std::span<const std::uint32_t> block) {
    made.faces = contacts[block[0]].manifold.count > 1;
    made.count = 0;
    made.change = {};
    made.a_moves = made.b_moves = made.a_below = made.b_below = made.joined = 0;
    for (const std::uint32_t contact : block) {
      if (contact == ContactOrder::kNone) break;
      const std::size_t lane = made.count++;
      made.contact[lane] = contact;
      set_row(contacts[contact], ctx.bodies, ctx.gravity, made, lane);
      const std::uint32_t a = support.distance(made.a[lane]);
      const std::uint32_t b = support.distance(made.b[lane]);
      made.a_below = static_cast<LaneMask>(made.a_below | unsigned{a < b} << lane);
      made.b_below = static_cast<LaneMask>(made.b_below | unsigned{b < a} << lane);
      const bool on_joint =
          ctx.bodies[made.a[lane]].projected || ctx.bodies[made.b[lane]].projected;
      made.joined = static_cast<LaneMask>(made.joined | unsigned{on_joint} << lane);
    }
    repeat_first_row(made);
    kernels->prepare(made, kAllLanes, numbers);
  };
  const auto block = [&](std::size_t k) {
    return places.subspan(std::min(k, blocks - 1) * kLanes, kLanes);
  };
  ctx.workers->for_chunks(rows.size(), kGrain / kLanes,
                          [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t k = begin; k < end; ++k) {
                              prefetch_contacts(block(k + 2));
                              prefetch_bodies(block(k + 1), ctx.bodies);
                              prepare(rows[k], block(k));
                            }
                          });
  own.joined = ctx.workers->any_chunk(rows.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    return std::any_of(rows.begin() + begin, rows.begin() + end,
                       [](const ContactRows& r) { return r.joined != 0; });
  });
}

void ContactBlock::Impl::renew_rows(const SubstepContext& ctx) {
  if (std::none_of(ctx.members.begin(), ctx.members.end(),
                   [&](std::uint32_t body) { return ctx.bodies[body].reoriented; }))
    return;
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  for_rows(ctx, [&](ContactRows& each) {
    LaneMask asked = 0;
    for (std::size_t lane = 0; lane < each.count; ++lane) {
      if (!ctx.bodies[each.a[lane]].reoriented && !ctx.bodies[each.b[lane]].reoriented) continue;
      set_arms(contacts[each.contact[lane]], ctx.bodies, each, lane);
      asked = static_cast<LaneMask>(asked | 1u << lane);
    }
    if (asked == 0) return;
    repeat_first_row(each);
    if ((asked & 1u) != 0) asked = static_cast<LaneMask>(asked | (kAllLanes & ~lanes_in_use(each)));
    kernels->prepare(each, asked, numbers);
  });
}

void ContactBlock::begin_substep(const SubstepContext& ctx) {
  Impl& m = *impl_;
  const double fall = fall_of(ctx);
  const SubstepRule rule{.h = ctx.h,
                         .first = ctx.substep == 0,
                         .push_speed = m.options.push_speed,
                         .push_slop = push_slop(ctx) * fall * ctx.h,
                         .warm_start_gap = m.options.warm_start_gap,
                         .bounce_speed = m.options.restitution_threshold * fall,
                         .resting = m.options.resting_tolerance * fall,
                         .growth = fall};
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  ContactGroup& own = m.group(ctx);
  if (ctx.substep == 0) {
    own.turned = false;
    m.make_rows(ctx);
    own.budget_spent = m.spent(ctx);
    own.refined_rows += m.rows_beyond(m.order.row_count(ctx.group), ctx.substeps);
  }
  if (std::exchange(own.turned, false) || own.joined) m.renew_rows(ctx);
  const AnchorNumbers anchors = anchors_of(m.contacts);
  m.for_rows(ctx, [&](ContactRows& rows) {
    m.prefetch_anchors(own.rows, rows);
    m.kernels->begin(rows, rule, numbers, anchors);
    if (rows.joined != 0) carry_near(rows, ctx);
  });
  if (!m.any_restitution) return;
  own.impacts.begin(own.rows, m.order.by_level(ctx.group), ctx.bodies, rule.bounce_speed);
}

void ContactBlock::warm_start(const SubstepContext& ctx) {
  Impl& m = *impl_;
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  const std::span<const ContactRows> rows = m.group(ctx).rows;
  m.order.sweep(ctx.group, false, *ctx.workers, [&](std::uint32_t k) {
    Impl::prefetch_bodies(rows, k, false, numbers);
    m.kernels->warm_start(rows[k], numbers);
  });
}

double ContactBlock::project(const SubstepContext& ctx) {
  Impl& m = *impl_;
  ContactGroup& own = m.group(ctx);
  const std::span<ContactRows> rows = own.rows;
  const bool first_substep = ctx.substep == 0;
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  m.order.sweep(ctx.group, ctx.reverse, *ctx.workers, [&](std::uint32_t k) {
    Impl::prefetch_bodies(rows, k, ctx.reverse, numbers);
    m.kernels->solve(rows[k], ContactPass::Motion, normal_friction_iterations(first_substep),
                     kAllLanes, numbers);
  });
  const ContactConvergence::Rule rule{.tolerance = m.options.resting_tolerance * fall_of(ctx),
                                      .rows = m.rows_to_sweep(own.budget_spent, ctx),
                                      .sweeps = m.options.extra_sweeps,
                                      .first_substep = first_substep};
  const auto [swept, open] = own.convergence.run(rule, m.order, ctx.group, ctx.reverse, rows,
                                                 *m.kernels, ctx.bodies, *ctx.workers);
  own.extra_rows += swept;
  own.open_rows = std::max(own.open_rows, open);
  own.turned = true;
  const double change = ctx.h * m.largest_change(ctx);
  // Overlaps were measured at the start of the substep; the first iteration has opened them.
  if (ctx.iteration > 0) return change;
  for (const std::uint32_t body : ctx.members) m.pushed[body] = 0;
  m.order.sweep(ctx.group, ctx.reverse, *ctx.workers, [&](std::uint32_t k) {
    m.push(rows[k], static_cast<LaneMask>(rows[k].penetrating & ~m.held(rows[k], ctx)),
           m.kernels->push, numbers);
  });
  if (ctx.shared) yield_to_gaps(ctx);
  return change;
}

double ContactBlock::project_displacement(const SubstepContext& ctx) {
  Impl& m = *impl_;
  double fastest = 0.0;
  for (const std::uint32_t i : ctx.members) {
    const SolverBody& body = ctx.bodies[i];
    m.pushed[i] = body.held && !(body.v_push.isZero(0.0) && body.w_push.isZero(0.0)) ? 1 : 0;
    if (m.pushed[i] == 0) continue;
    const double rim = kLeverArm * body.w_push.norm();
    fastest = std::max(fastest, body.v_push.squaredNorm() + rim * rim);
  }
  // Displacement below the slop causes no overlap.
  const double slop = kPushSlop * fall_of(ctx);  // m/s
  const int sweeps = fastest > slop * slop ? kHoldSweeps : 1;
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  for (int i = 0; i < sweeps; ++i) {
    m.order.sweep(ctx.group, (i % 2 == 0) == ctx.reverse, *ctx.workers, [&](std::uint32_t k) {
      const ContactRows& rows = m.group(ctx).rows[k];
      const auto meant = static_cast<LaneMask>(rows.penetrating & m.held(rows, ctx));
      m.push(rows, meant, m.kernels->hold, numbers);
    });
  }
  return 0.0;
}

double ContactBlock::solve_velocity(const SubstepContext& ctx) {
  Impl& m = *impl_;
  const bool first_substep = ctx.substep == 0;
  const BodyNumbers numbers = numbers_of(ctx.bodies);
  ContactGroup& own = m.group(ctx);
  const std::span<ContactRows> rows = own.rows;
  if (std::exchange(own.turned, false)) m.renew_rows(ctx);
  if (m.any_restitution) {
    own.impacts.run(rows, *m.kernels, ctx.bodies, m.rows_to_sweep(0, ctx));
  }
  m.order.sweep(ctx.group, ctx.reverse, *ctx.workers, [&](std::uint32_t k) {
    Impl::prefetch_bodies(rows, k, ctx.reverse, numbers);
    m.kernels->solve(rows[k], ContactPass::Velocity, normal_friction_iterations(first_substep),
                     kAllLanes, numbers);
  });
  return m.largest_change(ctx);
}

void ContactBlock::finish_velocity(const SubstepContext& ctx) {
  if (!ctx.last) return;
  const double growth = fall_of(ctx);
  const auto finish = [&](const ContactRows& rows, std::size_t lane) {
    Contact& contact = impl_->contacts[rows.contact[lane]];
    const double load = rows.load(lane);
    contact.impulse = rows.pressed[lane] + load;
    contact.approach_speed = std::max(rows.fastest[lane], load > 0.0 ? rows.approach[lane] : 0.0);
    contact.warm_start_scale = warm_start_scale(rows, lane, growth);
    contact.friction_force = friction_of(rows, lane) / ctx.h;
    // A non-finite step must not spoil the next one.
    for (std::size_t i = 0; i < rows.most_points(); ++i) {
      const double impulse = rows.impulse[i][lane];
      contact.force[i] = std::isfinite(impulse) ? impulse / ctx.h : 0.0;
    }
    carry_friction(contact, rows.faces ? rows.twist[lane] / ctx.h : 0.0);
  };
  const std::span<const ContactRows> all = impl_->group(ctx).rows;
  impl_->for_rows(ctx, [&](const ContactRows& rows) {
    const std::size_t soon = static_cast<std::size_t>(&rows - all.data()) + Impl::kAhead;
    if (soon < all.size()) impl_->prefetch_results(all[soon]);
    for (std::size_t lane = 0; lane < rows.count; ++lane) finish(rows, lane);
  });
}

void ContactBlock::end_step(const SubstepContext& ctx, std::span<double> wanted) {
  Impl& m = *impl_;
  m.briefs();  // makes all briefs
  m.add_up_groups();
  m.worst.assign(static_cast<std::size_t>(ctx.workers->count()), 0.0);
  ctx.workers->for_chunks(m.contacts.size(), Impl::kGrain,
                          [&](std::size_t begin, std::size_t end, int w) {
                            double& worst = m.worst[static_cast<std::size_t>(w)];
                            for (std::size_t k = begin; k < end; ++k) {
                              finish_contact(m.contacts[k], ctx.bodies, worst);
                              m.brief_list[k] = Impl::brief_of(m.contacts[k]);
                            }
                          });
  m.residual = *std::max_element(m.worst.begin(), m.worst.end());
  for (const std::uint32_t i : ctx.movers) m.pushed[i] = 0;
  if (wanted.empty()) return;
  m.refused_rows = m.refinement.want(m.contacts, m.sequence, m.options.extra_rows, ctx, wanted);
}

BlockReport ContactBlock::report() const {
  return {.name = name(),
          .rows = static_cast<int>(impl_->kept().size()),
          .extra_rows = impl_->extra_rows,
          .refined_rows = impl_->refined_rows,
          .refused_rows = impl_->refused_rows,
          .open_rows = impl_->open_rows,
          .residual = impl_->residual};
}

}  // namespace tandem::pbd
