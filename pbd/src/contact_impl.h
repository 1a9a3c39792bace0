// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "contact_cells.h"
#include "contact_convergence.h"
#include "contact_impact.h"
#include "contact_order.h"
#include "contact_refinement.h"
#include "contact_row.h"
#include "contact_rows.h"
#include "contact_statics.h"
#include "contact_support.h"
#include "tandem/pbd/by_body.h"

namespace tandem::pbd {

/// Carries the forces of a pair's points over to its contact in this step.
/// @param old  contact in the last step; may be the same object
void follow(const Manifold& manifold, const Contact& old, Contact& contact);
/// Sets the friction that the next step starts from: see kFrictionShare.
void carry_friction(Contact& contact, double twist);

/// The rows of a group while it is solved, and its statistics.
struct ContactGroup {
  std::vector<ContactRows> room;
  std::span<ContactRows> rows;  ///< in block order
  ContactConvergence convergence;
  ContactImpacts impacts;
  std::vector<double> sums;  ///< by worker, scratch
  int budget_spent = 0;      ///< rows of refinement, see ContactBlock::Impl::spent()
  bool turned = false;       ///< poses have moved since rows were made or renewed
  bool joined = false;       ///< some row has a body with joints
  // Sums over all groups that were solved here in this step:
  int extra_rows = 0;    ///< swept again
  int refined_rows = 0;  ///< in substeps beyond the solver's
  int open_rows = 0;     ///< left unsolved, in the worst substep

  /// Reserves for any group that may be solved at once; which ones is not known in advance.
  void reserve(std::size_t blocks, std::size_t bodies, bool bounces) {
    if (blocks > 0) {
      make_room(blocks);
      convergence.reserve(blocks, bodies);
    }
    if (bounces) impacts.reserve(bodies, blocks);
  }
  void make_room(std::size_t blocks) {
    if (blocks <= room.capacity()) return;
    room = {};  // freed first: there is nothing to copy
    room.reserve(blocks + blocks / 4);
  }
};

struct __attribute__((visibility("hidden"))) ContactBlock::Impl {
  static constexpr std::size_t kAhead = 2;         ///< blocks of rows
  static constexpr std::size_t kGrain = 64;        ///< contacts per chunk of a worker
  static constexpr std::size_t kBriefGrain = 512;  ///< the same for cheap passes

  std::vector<Contact> contacts;         ///< by ascending key; between steps see kept()
  std::vector<Contact> next_contacts;    ///< scratch of follow_all() with workers
  std::vector<std::uint32_t> old_place;  ///< index of each in the last step, or kNone
  std::vector<std::uint8_t> goes_on;     ///< by contact of the last step: it persists
  std::vector<ContactBrief> brief_list;  ///< see briefs()
  bool briefs_are_old = false;
  std::vector<std::uint32_t> sequence;  ///< contacts by Manifold::order; empty: by key
  std::vector<std::pair<std::uint64_t, std::uint32_t>> ranks;  ///< scratch of put_in_sequence()
  ByBody by_body;                                              ///< contacts; see named()
  bool gone = false;                   ///< some contacts name removed bodies
  std::vector<std::uint32_t> changed;  ///< bodies that lost a load, until the next step
  std::vector<std::uint8_t>
      pushed;                 ///< by body: has v_push or w_push in this substep; 0 between steps
  std::vector<double> worst;  ///< m, by worker
  ContactSupport support;
  ContactStatics statics;
  ContactCells cells;
  ContactOrder order;
  std::vector<ContactGroup> groups;  ///< groups that are solved at once: by worker
  ContactRefinement refinement;
  struct Level {
    int substeps = 0;
    int rows = 0;
  };
  std::vector<Level> levels;  ///< see count_levels()
  ContactOptions options;
  const ContactKernels* kernels = &contact_kernels(0);
  int extra_rows = 0;      ///< rows swept again in this step
  int refined_rows = 0;    ///< rows of substeps beyond the solver's
  int refused_rows = 0;    ///< such rows, wanted for the next step and refused
  int open_rows = 0;       ///< rows left unsolved, in the worst substep
  int least_substeps = 1;  ///< the solver's
  double residual = 0.0;
  double last_h = 0.0;  ///< s, length of a substep in the last step; 0: there was none
  bool any_friction = false;
  bool any_restitution = false;

  ContactGroup& group(const SubstepContext& ctx) {
    return groups[static_cast<std::size_t>(ctx.worker)];
  }
  std::size_t most_blocks_at_once(std::span<const GroupFacts> all) const {
    std::size_t most = 0;
    for (std::uint32_t g = 0; g < all.size(); ++g) {
      if (all[g].at_once) most = std::max(most, order.places(g).size() / kLanes);
    }
    return most;
  }
  void add_up_groups() {
    extra_rows = refined_rows = open_rows = 0;
    for (const ContactGroup& each : groups) {
      extra_rows += each.extra_rows;
      refined_rows += each.refined_rows;
      open_rows = std::max(open_rows, each.open_rows);
    }
  }

  /// The contacts, without those of bodies removed since the last step.
  std::vector<Contact>& kept() {
    if (!gone) return contacts;
    gone = false;
    std::erase_if(contacts, [](const Contact& c) { return c.manifold.body_a == BodyId::kNone; });
    by_body.outdate();
    briefs_are_old = true;
    return contacts;
  }
  static ContactBrief brief_of(const Contact& contact) {
    const Manifold& m = contact.manifold;
    return {.a = m.body_a,
            .b = m.body_b,
            .face = m.count > 1,
            .loaded = contact.loaded(),
            .is_new = !(contact.overlap >= 0.0),
            .rubs = m.friction > 0.0};
  }
  std::span<const ContactBrief> briefs() {
    kept();
    if (!std::exchange(briefs_are_old, false)) return brief_list;
    brief_list.clear();
    for (const Contact& contact : contacts) brief_list.push_back(brief_of(contact));
    return brief_list;
  }
  void match(std::span<const Manifold> manifolds, Workers& workers);
  void follow_all(std::span<const Manifold> manifolds, Workers& workers);
  /// @param into  contacts, if none moves, or next_contacts
  void follow_at_once(std::span<const Manifold> manifolds, std::span<Contact> into,
                      Workers& workers);
  void follow_in_turn(std::span<const Manifold> manifolds);
  /// Made on demand after a step.
  const ByBody& named() {
    by_body.renew([&] {
      for (std::uint32_t k = 0; k < contacts.size(); ++k) {
        by_body.add(k, contacts[k].manifold.body_a, contacts[k].manifold.body_b);
      }
    });
    return by_body;
  }
  /// A contact without a successor: the bodies that it supported must wake.
  void note_lost(const Contact& lost) {
    if (!lost.loaded() || !(lost.warm_start_scale > 0.0)) return;
    changed.push_back(lost.manifold.body_a);
    changed.push_back(lost.manifold.body_b);
  }

  /// The force at the end of a much shorter step is no load: it is the impulse that stopped a
  /// motion, over the step's length. Awake contacts become new ones, whose loads ContactStatics
  /// guesses. Without this, stacks of eight under steps of 1e-12 to 0.2 s move by up to 60 % of an
  /// edge; by less than 0.5 % for ratios from 1.2 to 100.
  void forget_loads(const SubstepContext& ctx) {
    constexpr double kMuchLonger = 10.0;
    const bool much_longer = last_h > 0.0 && ctx.h > kMuchLonger * last_h;
    last_h = ctx.h;
    if (!much_longer) return;
    for (Contact& contact : contacts) {
      const Manifold m = contact.manifold;
      const bool awake = ctx.bodies[m.body_a].is_solved() || ctx.bodies[m.body_b].is_solved();
      if (awake) contact = {.manifold = m};
    }
    briefs_are_old = true;
  }

  void put_in_sequence() {
    const auto before = [](const Contact& l, const Contact& r) {
      return l.manifold.order < r.manifold.order;
    };
    sequence.clear();
    if (std::is_sorted(contacts.begin(), contacts.end(), before)) return;
    ranks.clear();  // gathered: contacts are scattered in memory
    for (std::uint32_t i = 0; i < contacts.size(); ++i) {
      ranks.emplace_back(contacts[i].manifold.order, i);
    }
    std::sort(ranks.begin(), ranks.end());
    for (const auto& [rank, contact] : ranks) sequence.push_back(contact);
  }

  /// Prefetch: bodies are scattered in memory.
  static void prefetch_bodies(std::span<const ContactRows> rows, std::size_t k, bool reverse,
                              BodyNumbers bodies) {
    if (reverse ? k < kAhead : k + kAhead >= rows.size()) return;
    const ContactRows& soon = rows[reverse ? k - kAhead : k + kAhead];
    for (std::size_t i = 0; i < kLanes; ++i) {
      for (const double* body : {bodies.of(soon.a[i]), bodies.of(soon.b[i])}) {
        __builtin_prefetch(body);
        __builtin_prefetch(body + 8);
      }
    }
  }

  /// Prefetch: the contacts for a block, and their bodies once known.
  void prefetch_contacts(std::span<const std::uint32_t> block) const {
    for (const std::uint32_t i : block) {
      if (i == ContactOrder::kNone) break;
      prefetch_all(contacts[i]);
    }
  }
  void prefetch_bodies(std::span<const std::uint32_t> block,
                       std::span<const SolverBody> bodies) const {
    for (const std::uint32_t i : block) {
      if (i == ContactOrder::kNone) break;
      prefetch_all(bodies[contacts[i].manifold.body_a]);
      prefetch_all(bodies[contacts[i].manifold.body_b]);
    }
  }
  /// Prefetch: the points of the contacts of the block after the next one.
  void prefetch_anchors(std::span<const ContactRows> rows, const ContactRows& block) const {
    const std::size_t soon = static_cast<std::size_t>(&block - rows.data()) + kAhead;
    if (soon >= rows.size()) return;
    for (const std::uint32_t contact : rows[soon].contact) {
      prefetch_all(contacts[contact].manifold.points);
    }
  }
  /// Prefetch: the places in contacts that a solved block writes to.
  void prefetch_results(const ContactRows& block) const {
    for (std::size_t lane = 0; lane < block.count; ++lane) {
      const auto* results = reinterpret_cast<const char*>(&contacts[block.contact[lane]].force);
      __builtin_prefetch(results, 1);
      __builtin_prefetch(results + 64, 1);
    }
  }
  template <class T>
  static void prefetch_all(const T& object) {
    const auto* bytes = reinterpret_cast<const char*>(&object);
    for (std::size_t at = 0; at < sizeof(T); at += 64) __builtin_prefetch(bytes + at);
  }

  /// Calls visit(rows) for all blocks of rows of the group, divided among workers.
  void for_rows(const SubstepContext& ctx, auto&& visit) {
    const std::span<ContactRows> rows = group(ctx).rows;
    ctx.workers->for_chunks(rows.size(), kGrain / kLanes,
                            [&](std::size_t begin, std::size_t end, int) {
                              for (std::size_t k = begin; k < end; ++k) visit(rows[k]);
                            });
  }

  /// Lanes with a body whose displacement is held.
  static LaneMask held(const ContactRows& each, const SubstepContext& ctx) {
    LaneMask lanes = 0;
    for (std::size_t i = 0; ctx.shared && i < each.count; ++i) {
      const bool with = ctx.bodies[each.a[i]].held || ctx.bodies[each.b[i]].held;
      lanes = static_cast<LaneMask>(lanes | unsigned{with} << i);
    }
    return lanes;
  }
  /// See ContactKernels::push and hold; marks the bodies that they move.
  void push(const ContactRows& each, LaneMask meant, decltype(ContactKernels::push) act,
            BodyNumbers bodies) {
    LaneMask asked = meant;
    for (std::size_t i = 0; i < each.count; ++i) {
      if ((pushed[each.a[i]] | pushed[each.b[i]]) != 0)
        asked = static_cast<LaneMask>(asked | 1u << i);
    }
    if (asked == 0) return;
    const LaneMask acted = act(each, asked, bodies);
    for (std::size_t i = 0; i < each.count; ++i) {
      // Immovable bodies may be shared by rows that are solved at once.
      if ((acted & each.a_moves) >> i & 1u) pushed[each.a[i]] = 1;
      if ((acted & each.b_moves) >> i & 1u) pushed[each.b[i]] = 1;
    }
  }

  /// Counts contacts by the substeps of their groups, once the order of the step is known.
  void count_levels(std::span<const GroupFacts> all) {
    levels.clear();
    for (std::uint32_t g = 0; g < all.size(); ++g) {
      const auto level = std::find_if(levels.begin(), levels.end(), [&](const Level& each) {
        return each.substeps == all[g].substeps;
      });
      if (level != levels.end()) {
        level->rows += order.row_count(g);
      } else {
        levels.push_back({all[g].substeps, order.row_count(g)});
      }
    }
  }
  int rows_beyond(int rows, int substeps) const { return rows * (substeps - least_substeps); }
  /// Budget of further rows that is spent before a group: by groups with fewer substeps, and by
  /// this one as if all of its level were like it, so that their order does not matter.
  int spent(const SubstepContext& ctx) const {
    int below = 0;
    for (const Level& level : levels) {
      if (level.substeps < ctx.substeps) below += rows_beyond(level.rows, level.substeps);
    }
    const int own = rows_beyond(order.row_count(ctx.group), ctx.substeps);
    return below + static_cast<int>(own / ctx.share_of_budget);
  }
  /// Rows that may be swept again, or hit by impacts, per substep of a step.
  /// @param spent  part of the budget
  int rows_to_sweep(int spent, const SubstepContext& ctx) const {
    constexpr int kPart = 6;  // see ContactOptions::extra_rows
    const int left = std::max(0, options.extra_rows - spent) / (kPart * ctx.substeps);
    return static_cast<int>(ctx.share_of_budget * left);
  }

  /// Makes the rows of the group that is solved next.
  void make_rows(const SubstepContext& ctx);
  /// Renews the rows of bodies that torque-free rotation or joints have turned. Arms and inertia of
  /// the old pose would take the turn of the spin axis for an impact: a dowel of 1 x 60 cm that
  /// rolls at 1 m/s and yaws by 0.5 rad/s had 1e5 times its energy after 5 s. With joints, an
  /// impulse that removes energy by the inertia of one pose adds some by that of another, and
  /// joints and contacts alternate: links turn by 0.05 rad in a substep, but in a step of 1/30 s by
  /// 7, and a whipping chain of 11 went from 130 to 3500 J within ten of its 128 substeps.
  void renew_rows(const SubstepContext& ctx);

  /// m/s, largest change of a normal velocity in the last sweep.
  double largest_change(const SubstepContext& ctx) {
    ContactGroup& own = group(ctx);
    own.sums.assign(static_cast<std::size_t>(ctx.workers->count()), 0.0);
    ctx.workers->for_chunks(
        own.rows.size(), kGrain, [&](std::size_t begin, std::size_t end, int worker) {
          double largest = 0.0;
          for (std::size_t k = begin; k < end; ++k) {
            const Lanes& change = own.rows[k].change;
            largest = std::max(largest, *std::max_element(change.begin(), change.end()));
          }
          double& of_worker = own.sums[static_cast<std::size_t>(worker)];
          of_worker = std::max(of_worker, largest);
        });
    return *std::max_element(own.sums.begin(), own.sums.end());
  }
};

}  // namespace tandem::pbd
