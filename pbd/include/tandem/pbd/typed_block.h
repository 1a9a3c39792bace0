// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "tandem/pbd/by_body.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/slots.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {

namespace detail {
/// Whether `free` names each slot that is not alive, once.
TANDEM_API bool are_free_slots(std::span<const std::uint32_t> free,
                               std::span<const std::uint8_t> alive);
}  // namespace detail

/// Names one row of one TypedBlock; stale ids are refused.
struct TANDEM_API ConstraintId {
  std::uint32_t index = BodyId::kNone;
  std::uint32_t generation = 0;
  friend auto operator<=>(const ConstraintId&, const ConstraintId&) = default;
};

/// All constraints of kind C in one array, swept in the order of slots, or of bodies if those have
/// stable ids.
///
/// C is a plain class with the verbs of ConstraintBlock that it needs, for one row:
///   static constexpr std::string_view kName;  static constexpr int kOrder;
///   struct Def; static void check(const World&, const Def&) (throws); explicit C(const Def&);
///   BodyId body_a() const, body_b() const (the invalid id stands for the world);
///   double residual() const; double displacement_residual() const;
///   void save(ByteWriter&) const; void load(ByteReader&); const Def& def() const; Def& def();
///   double project(const SubstepContext&) (the move that it asked for, m);
/// and optionally
///   forgive (at the start of a step, rows with a body in SubstepContext::displaced),
///   bool find_gap (at the start of a step, all other rows: see has_gaps()),
///   begin_substep, solve_velocity, finish_velocity, begin_displacement,
///   project_displacement, end_displacement, end_step;
///   bool names(BodyId) const, append_edges(std::vector<ConstraintEdge>&) const
///   (both for the bodies beyond the first two of a row);
///   static constexpr bool kGroupsAtOnce = true
///   (rows write to nothing shared and to no immovable body);
///   bool active() const (false leaves the row out),
///   actuated() const, force_driven() const (see ConstraintEdge).
/// If C can be copied, so can the block (WorldCopy).
template <class C>
class TANDEM_API TypedBlock final : public ConstraintBlock {
 public:
  using Def = typename C::Def;

  /// @throws std::invalid_argument naming the field, its value and the rule
  ConstraintId add(const World& world, const Def& def) {
    C::check(world, def);
    changed(def);
    sequence_is_old_ = true;
    const std::uint32_t index = slots_.take();
    if (index == rows_.size()) {
      rows_.emplace_back(def);
    } else {
      rows_[index] = C(def);
    }
    by_body_.add(index, rows_[index].body_a().index, rows_[index].body_b().index);
    return {index, slots_.generation(index)};
  }

  bool contains(ConstraintId id) const { return slots_.contains(id.index, id.generation); }
  void remove(ConstraintId id) { erase(checked(id)); }
  /// The returned references are valid until a row is added, or the block is loaded or assigned to.
  const C& at(ConstraintId id) const { return rows_[checked(id)]; }
  const Def& def(ConstraintId id) const { return rows_[checked(id)].def(); }
  /// Change parameters; carried state stays.
  /// @throws std::invalid_argument  if it names other bodies
  void set(const World& world, ConstraintId id, const Def& def) {
    const std::uint32_t index = checked(id);
    C::check(world, def);
    const C row(def);
    refuse_other(row.body_a(), rows_[index].body_a());
    refuse_other(row.body_b(), rows_[index].body_b());
    rows_[index].def() = def;
    changed(def);
  }
  int size() const { return static_cast<int>(slots_.count()); }

  std::string_view name() const override { return C::kName; }
  int order() const override { return C::kOrder; }
  bool empty() const override { return slots_.count() == 0; }
  bool groups_at_once() const override {
    if constexpr (requires { C::kGroupsAtOnce; }) return C::kGroupsAtOnce;
    return false;
  }

  void begin_step(const SubstepContext& ctx) override {
    put_in_sequence(ctx.order);
    sort_by_group(ctx.bodies);
    const auto moved = [&](BodyId id) {
      return id.valid() && !ctx.displaced.empty() && ctx.displaced[id.index] != 0;
    };
    gaps_ = false;
    sweep(false, [&](C& c) {
      if (!is_active(c)) return;
      const bool displaced = moved(c.body_a()) || moved(c.body_b());
      if constexpr (requires { c.forgive(ctx); }) {
        if (displaced) c.forgive(ctx);
      }
      if constexpr (requires { c.find_gap(ctx); }) {
        if (!displaced && c.find_gap(ctx)) gaps_ = true;
      }
    });
  }
  bool has_gaps() const override { return gaps_; }
  void begin_substep(const SubstepContext& ctx) override {
    if constexpr (requires(C & c) { c.begin_substep(ctx); }) {
      sweep_group(ctx, [&](C& c) { c.begin_substep(ctx); });
    }
  }
  double project(const SubstepContext& ctx) override {
    double largest = 0.0;
    sweep_group(ctx, [&](C& c) { largest = std::max(largest, c.project(ctx)); });
    return largest;
  }
  double solve_velocity(const SubstepContext& ctx) override {
    double change = 0.0;
    if constexpr (requires(C & c) { c.solve_velocity(ctx); }) {
      sweep_group(ctx, [&](C& c) { change = std::max(change, c.solve_velocity(ctx)); });
    }
    return change;
  }
  void finish_velocity(const SubstepContext& ctx) override {
    if constexpr (requires(C & c) { c.finish_velocity(ctx); }) {
      sweep_group(ctx, [&](C& c) { c.finish_velocity(ctx); });
    }
  }
  void begin_displacement(const SubstepContext& ctx) override {
    if constexpr (requires(C & c) { c.begin_displacement(ctx); }) {
      sweep_shared(ctx, [&](C& c) { c.begin_displacement(ctx); });
    }
  }
  double project_displacement(const SubstepContext& ctx) override {
    double largest = 0.0;
    if constexpr (requires(C & c) { c.project_displacement(ctx); }) {
      sweep_shared(ctx, [&](C& c) { largest = std::max(largest, c.project_displacement(ctx)); });
    }
    return largest;
  }
  void end_displacement(const SubstepContext& ctx) override {
    if constexpr (requires(C & c) { c.end_displacement(ctx); }) {
      sweep_shared(ctx, [&](C& c) { c.end_displacement(ctx); });
    }
  }
  void end_step(const SubstepContext& ctx, std::span<double> /*wanted*/) override {
    if constexpr (requires(C & c) { c.end_step(ctx); }) {
      sweep(false, [&](C& c) { c.end_step(ctx); });
    }
  }

  void append_edges(std::vector<ConstraintEdge>& edges) const override { append_rows(edges, true); }
  void append_idle(std::vector<ConstraintEdge>& edges) const override { append_rows(edges, false); }
  void take_changed(std::vector<std::uint32_t>& bodies) override {
    bodies.insert(bodies.end(), changed_.begin(), changed_.end());
    changed_.clear();
  }
  void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const override {
    by_body().for_rows(body, [&](std::uint32_t row, std::uint32_t other) {
      if (is_active(rows_[row]) && other != BodyId::kNone) joined.push_back(other);
    });
  }
  void remove_body(BodyId body) override {
    for (const std::uint32_t row : by_body().rows_of(body.index)) erase(row);
    if constexpr (requires(const C& c) { c.names(body); }) {
      for (std::uint32_t i = 0; i < rows_.size(); ++i) {
        if (slots_.alive(i) && rows_[i].names(body)) erase(i);
      }
    }
  }
  BlockReport report() const override {
    BlockReport report{.name = C::kName, .rows = size()};
    for (std::uint32_t i = 0; i < rows_.size(); ++i) {
      if (!slots_.alive(i)) continue;
      report.residual = std::max(report.residual, rows_[i].residual());
      report.displacement_residual =
          std::max(report.displacement_residual, rows_[i].displacement_residual());
    }
    return report;
  }
  void save(ByteWriter& out) const override {
    out.u32(static_cast<std::uint32_t>(rows_.size()));
    for (std::uint32_t i = 0; i < rows_.size(); ++i) {
      slots_.save_slot(out, i);
      rows_[i].save(out);
    }
    slots_.save_free(out);
    out.u32(static_cast<std::uint32_t>(changed_.size()));
    for (const std::uint32_t body : changed_) out.u32(body);
  }
  bool fits(const World& world) const override {
    try {
      for (std::uint32_t i = 0; i < rows_.size(); ++i) {
        if (slots_.alive(i)) C::check(world, rows_[i].def());
      }
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  }
  void load(ByteReader& in) override {
    const std::uint32_t size = in.u32();
    rows_.clear();
    slots_.clear();
    by_body_.outdate();  // rebuilt later: the input may name bodies that do not exist
    sequence_is_old_ = true;
    for (std::uint32_t i = 0; i < size && !in.failed(); ++i) {
      slots_.load_slot(in);
      rows_.emplace_back(Def{});
      rows_.back().load(in);
    }
    slots_.load_free(in);
    changed_.clear();
    const std::uint32_t changed_count = in.u32();
    for (std::uint32_t i = 0; i < changed_count && !in.failed(); ++i) changed_.push_back(in.u32());
  }

  std::unique_ptr<ConstraintBlock> make_empty() const override {
    if constexpr (std::is_copy_constructible_v<C> && std::is_copy_assignable_v<C>) {
      return std::make_unique<TypedBlock>();
    } else {
      return nullptr;
    }
  }
  bool assign(const ConstraintBlock& source) override {
    if constexpr (std::is_copy_constructible_v<C> && std::is_copy_assignable_v<C>) {
      const auto* other = dynamic_cast<const TypedBlock*>(&source);
      if (other == nullptr) return false;
      *this = *other;
      slots_.assign(other->slots_);
      return true;
    } else {
      return false;
    }
  }

 private:
  template <class Visit>
  void sweep(bool reverse, Visit&& visit) {
    const std::size_t n = sequence_.empty() ? rows_.size() : sequence_.size();
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t at = reverse ? n - 1 - k : k;
      const auto i = sequence_.empty() ? static_cast<std::uint32_t>(at) : sequence_[at];
      if (slots_.alive(i)) visit(rows_[i]);
    }
  }
  void put_in_sequence(const BodyOrder& order) {
    if (!sequence_is_old_ && natural_ == order.natural()) return;
    sequence_is_old_ = false;
    natural_ = order.natural();
    sequence_.clear();
    if (natural_) return;
    for (std::uint32_t i = 0; i < rows_.size(); ++i) sequence_.push_back(i);
    std::sort(sequence_.begin(), sequence_.end(), [&](std::uint32_t l, std::uint32_t r) {
      return order.row_before(rows_[l].body_a(), rows_[l].body_b(), l, rows_[r].body_a(),
                              rows_[r].body_b(), r);
    });
  }
  void append_rows(std::vector<ConstraintEdge>& edges, bool active) const {
    for (std::uint32_t i = 0; i < rows_.size(); ++i) {
      const C& c = rows_[i];
      if (!slots_.alive(i) || is_active(c) != active) continue;
      ConstraintEdge edge{.body_a = c.body_a().index, .body_b = c.body_b().index};
      if constexpr (requires { c.actuated(); }) edge.actuated = c.actuated();
      if constexpr (requires { c.force_driven(); }) edge.force_driven = c.force_driven();
      edges.push_back(edge);
      if constexpr (requires { c.append_edges(edges); }) c.append_edges(edges);
    }
  }
  static bool is_active(const C& c) {
    if constexpr (requires { c.active(); }) {
      return c.active();
    } else {
      return true;
    }
  }
  /// Sorts the rows of awake bodies by group, in sequence within each.
  void sort_by_group(std::span<const SolverBody> bodies) {
    const auto group_of = [&](const C& c) {
      std::uint32_t group = SolverBody::kNoGroup;
      for (const BodyId id : {c.body_a(), c.body_b()}) {
        if (id.valid()) group = std::min(group, bodies[id.index].group);
      }
      return group;
    };
    first_.assign(1, 0);
    sweep(false, [&](C& c) {
      const std::uint32_t group = group_of(c);
      if (group == SolverBody::kNoGroup) return;
      if (group + 2 > first_.size()) first_.resize(group + 2, 0);
      ++first_[group + 1];
    });
    for (std::size_t g = 1; g < first_.size(); ++g) first_[g] += first_[g - 1];
    by_group_.resize(first_.back());
    sweep(false, [&](C& c) {
      const std::uint32_t group = group_of(c);
      if (group == SolverBody::kNoGroup) return;
      by_group_[first_[group]++] = static_cast<std::uint32_t>(&c - rows_.data());
    });
    // Each entry has advanced to the begin of the next group.
    for (std::size_t g = first_.size() - 1; g > 0; --g) first_[g] = first_[g - 1];
    first_[0] = 0;
  }
  static bool is_shared(const SubstepContext& ctx, const C& c) {
    return (c.body_a().valid() && ctx.bodies[c.body_a().index].shared) ||
           (c.body_b().valid() && ctx.bodies[c.body_b().index].shared);
  }
  template <class Visit>
  void sweep_group(const SubstepContext& ctx, Visit&& visit) {
    if (ctx.group + 1 >= first_.size()) return;
    const std::uint32_t begin = first_[ctx.group];
    const std::uint32_t count = first_[ctx.group + 1] - begin;
    for (std::uint32_t k = 0; k < count; ++k) {
      C& c = rows_[by_group_[begin + (ctx.reverse ? count - 1 - k : k)]];
      if (is_active(c)) visit(c);
    }
  }
  template <class Visit>
  void sweep_shared(const SubstepContext& ctx, Visit&& visit) {
    sweep_group(ctx, [&](C& c) {
      if (is_shared(ctx, c)) visit(c);
    });
  }
  static void refuse_other(BodyId given, BodyId kept) {
    if (given == kept) return;
    detail::refuse(std::string(C::kName) + ": body", "one that the row was added with",
                   std::to_string(given.index));
  }
  std::uint32_t checked(ConstraintId id) const {
    if (!contains(id)) {
      throw std::invalid_argument(std::string(C::kName) + ": id " + std::to_string(id.index) +
                                  " (generation " + std::to_string(id.generation) +
                                  ") names no constraint of this block");
    }
    return id.index;
  }
  void changed(const Def& def) {
    const C row(def);
    for (const BodyId id : {row.body_a(), row.body_b()}) {
      if (id.valid()) changed_.push_back(id.index);
    }
  }
  const ByBody& by_body() const {
    by_body_.renew([&] {
      for (std::uint32_t i = 0; i < rows_.size(); ++i) {
        if (slots_.alive(i)) by_body_.add(i, rows_[i].body_a().index, rows_[i].body_b().index);
      }
    });
    return by_body_;
  }
  void erase(std::uint32_t index) {
    changed(rows_[index].def());
    sequence_is_old_ = true;
    by_body_.remove(index);
    slots_.release(index);
  }

  std::vector<C> rows_;
  Slots slots_;
  mutable ByBody by_body_;
  std::vector<std::uint32_t> changed_;   ///< bodies to wake in the next step
  std::vector<std::uint32_t> sequence_;  ///< slots in the order of sweeps; empty = ascending
  std::vector<std::uint32_t> by_group_;  ///< slots sorted by group
  std::vector<std::uint32_t> first_;     ///< by group, first index into by_group_
  bool sequence_is_old_ = true;
  bool natural_ = true;  ///< order of bodies used for the sequence
  bool gaps_ = false;
};

}  // namespace tandem::pbd
