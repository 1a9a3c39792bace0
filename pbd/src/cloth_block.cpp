// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without cloth do not link it.
#include "tandem/pbd/cloth_block.h"

#include <algorithm>
#include <cmath>

#include "cloth_rows.h"
#include "cloth_sweep.h"
#include "tandem/pbd/corrections.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

using detail::refuse;
using detail::require;

void require_compliance(double compliance, std::string_view kind) {
  require(compliance >= 0.0 && std::isfinite(compliance), kind, "compliance", compliance,
          "finite and >= 0");
}
void require_length(double length, std::string_view kind, std::string_view field) {
  require(length > 0.0 && std::isfinite(length), kind, field, length, "finite and > 0");
}

}  // namespace

ClothBlock::ClothBlock()
    : rows_(std::make_shared<ClothRows>()), sweep_(std::make_unique<Sweep>()) {}
ClothBlock::~ClothBlock() = default;

bool ClothBlock::empty() const { return rows_->empty(); }

/// The rows for a change: cloned first if a copy of the world shares them.
ClothRows& ClothBlock::own_rows() {
  by_body_.outdate();
  if (rows_.use_count() > 1) rows_ = std::make_shared<ClothRows>(*rows_);
  return *rows_;
}

void ClothBlock::require_no_host(BodyId point, std::string_view kind) const {
  for (const ClothRows::Attachment& a : rows_->attachments) {
    require(a.host != point, kind, "points", point.index, "bodies that hold no particle");
  }
}

/// Reserves scalars for a new row. @return the index of the first one
std::uint32_t ClothBlock::take_scalars(std::size_t count, std::span<const BodyId> bodies) {
  for (const BodyId body : bodies) changed_.push_back(body.index);
  const auto at = static_cast<std::uint32_t>(carried_.size());
  carried_.resize(carried_.size() + count, 0.0);
  return at;
}

ClothRowId ClothBlock::add(const World& world, const StrandDef& def) {
  constexpr std::string_view kKind = "StrandDef";
  const std::size_t count = def.points.size();
  require(count >= 2, kKind, "number of points", static_cast<double>(count), "at least 2");
  require(def.lengths.empty() || def.lengths.size() + 1 == count, kKind, "number of lengths",
          static_cast<double>(def.lengths.size()), "one less than that of points, or 0");
  require_compliance(def.compliance, kKind);
  for (const BodyId point : def.points) {
    detail::require_body(world, point, kKind, "points");
    require_no_host(point, kKind);
  }
  std::vector<double> lengths = def.lengths;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    require(def.points[i] != def.points[i + 1], kKind, "points", def.points[i].index,
            "another body than the one before");
    if (def.lengths.empty()) {
      const Vec3 d = world.pose(def.points[i + 1]).position - world.pose(def.points[i]).position;
      lengths.push_back(d.norm());
    }
    require_length(lengths[i], kKind, "lengths");
  }
  lengths.push_back(0.0);
  ClothRows& rows = own_rows();
  const auto first = static_cast<std::uint32_t>(rows.points.size());
  const ClothRowId id{rows.next_id++};
  rows.strands.push_back({id.number, first, static_cast<std::uint32_t>(count), def.compliance,
                          take_scalars(count - 1, def.points)});
  rows.points.insert(rows.points.end(), def.points.begin(), def.points.end());
  rows.lengths.insert(rows.lengths.end(), lengths.begin(), lengths.end());
  return id;
}

ClothRowId ClothBlock::add(const World& world, const ClothTetherDef& def) {
  constexpr std::string_view kKind = "ClothTetherDef";
  detail::require_body(world, def.a, kKind, "a");
  detail::require_body(world, def.b, kKind, "b");
  require(def.a != def.b, kKind, "b", def.b.index, "another body than a");
  require_no_host(def.a, kKind);
  require_no_host(def.b, kKind);
  require_length(def.length, kKind, "length");
  ClothRows& rows = own_rows();
  const BodyId bodies[] = {def.a, def.b};
  const ClothRowId id{rows.next_id++};
  rows.tethers.push_back({id.number, def.a, def.b, def.length, take_scalars(1, bodies)});
  return id;
}

ClothRowId ClothBlock::add(const World& world, const MeanDef& def) {
  constexpr std::string_view kKind = "MeanDef";
  const std::size_t count = def.points.size();
  require(count >= 2, kKind, "number of points", static_cast<double>(count), "at least 2");
  require(def.weights.size() == count, kKind, "number of weights",
          static_cast<double>(def.weights.size()), "that of points");
  require_compliance(def.compliance, kKind);
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    detail::require_body(world, def.points[i], kKind, "points");
    require_no_host(def.points[i], kKind);
    require(std::isfinite(def.weights[i]), kKind, "weights", def.weights[i], "finite");
    sum += def.weights[i];
  }
  if (!all_differ(def.points)) refuse("MeanDef: points", "each once", "one twice");
  require(std::abs(sum) < 1e-9, kKind, "sum of weights", sum, "0");
  require(!def.leads || def.weights[0] != 0.0, kKind, "weight of the one that leads",
          def.weights[0], "not 0");
  ClothRows& rows = own_rows();
  const ClothRowId id{rows.next_id++};
  rows.means.push_back({.id = id.number,
                        .first = static_cast<std::uint32_t>(rows.mean_points.size()),
                        .count = static_cast<std::uint32_t>(count),
                        .compliance = def.compliance,
                        .leads = def.leads,
                        .at = take_scalars(3, def.points)});
  rows.mean_points.insert(rows.mean_points.end(), def.points.begin(), def.points.end());
  rows.weights.insert(rows.weights.end(), def.weights.begin(), def.weights.end());
  return id;
}

ClothRowId ClothBlock::add(const World& world, const AttachmentDef& def) {
  constexpr std::string_view kKind = "AttachmentDef";
  detail::require_body(world, def.particle, kKind, "particle");
  detail::require_body(world, def.host, kKind, "host");
  require(def.particle != def.host, kKind, "host", def.host.index, "another body");
  detail::require_finite(def.anchor_l, kKind, "anchor_l");
  for (const ClothRows::Attachment& other : rows_->attachments) {
    require(other.particle != def.particle, kKind, "particle", def.particle.index,
            "one that nothing holds");
  }
  require(!rows_->is_point(def.host), kKind, "host", def.host.index, "no point of another row");
  const BodyId bodies[] = {def.particle, def.host};
  ClothRows& rows = own_rows();
  const ClothRowId id{rows.next_id++};
  rows.attachments.push_back(
      {id.number, def.particle, def.host, def.anchor_l, take_scalars(3, bodies)});
  return id;
}

void ClothBlock::remove(ClothRowId id) {
  if (!contains(id)) {
    refuse("ClothBlock::remove: id", "that of a row of this block", std::to_string(id.number));
  }
  rows_->for_neighbours([&](BodyId a, BodyId b) {
    changed_.push_back(a.index);
    changed_.push_back(b.index);
  });
  own_rows().erase(
      carried_, [&](std::uint64_t number) { return number == id.number; },
      [](BodyId) { return false; });
}

bool ClothBlock::contains(ClothRowId id) const {
  const auto has = [&](const auto& list) {
    return std::any_of(list.begin(), list.end(),
                       [&](const auto& row) { return row.id == id.number; });
  };
  return has(rows_->strands) || has(rows_->tethers) || has(rows_->means) || has(rows_->attachments);
}

void ClothBlock::set_sweeps(int sweeps) {
  require(sweeps >= 1 && sweeps <= 100, "ClothBlock", "sweeps", sweeps, "from 1 to 100");
  sweeps_ = sweeps;
}

// RUN TIME PROPERTIES FOLLOW

void ClothBlock::begin_step(const SubstepContext& ctx) {
  sweep_->begin_step(*rows_, ctx, carried_.size());
  if (ctx.displaced.empty()) return;
  // Rows near bodies that agreement has placed keep their violation.
  bool touched = false;
  rows_->for_neighbours([&](BodyId a, BodyId b) {
    touched = touched || ctx.displaced[a.index] != 0 || ctx.displaced[b.index] != 0;
  });
  if (!touched) return;
  sweep_->violations(*rows_, ctx.bodies, Sweep::kAllGroups, sweep_->bounds);
  sweep_->for_rigid(*rows_, Sweep::kAllGroups, [&](std::uint32_t k, bool excess) {
    carried_[k] = excess ? std::max(0.0, sweep_->bounds[k]) : sweep_->bounds[k];
  });
}

void ClothBlock::begin_substep(const SubstepContext& ctx) {
  // Decay per substep of the violation that agreement left. At 0.92, the value of joints, a banner
  // of two resolutions is 67 mm apart and not 23 (tests/session/banner_test.cpp).
  constexpr double kCarriedDecay = 0.98;
  sweep_->calls = 0;
  const bool shared =
      ctx.shared && std::any_of(ctx.members.begin(), ctx.members.end(),
                                [&](std::uint32_t i) { return ctx.bodies[i].shared; });
  if (!shared) {
    sweep_->for_rigid(*rows_, ctx.group,
                      [&](std::uint32_t k, bool) { carried_[k] *= kCarriedDecay; });
  }
  sweep_->violations(*rows_, ctx.bodies, ctx.group, sweep_->bounds);
  sweep_->clear_lambdas(*rows_, ctx);
}

/// All sweeps at once; further ones while joints iterate, since these may have moved bodies that
/// hold the cloth.
int ClothBlock::sweeps_now() {
  constexpr int kMaxCalls = 5;
  const int call = sweep_->calls++;
  return call == 0 ? sweeps_ : (call < kMaxCalls ? 1 : 0);
}

double ClothBlock::project(const SubstepContext& ctx) {
  const int sweeps = sweeps_now();
  if (sweeps > 0) sweep_->run_real(*rows_, ctx, carried_, sweeps);
  return 0.0;
}

void ClothBlock::begin_displacement(const SubstepContext& ctx) {
  sweep_->calls = 0;
  sweep_->clear_lambdas(*rows_, ctx);
  sweep_->violations(*rows_, ctx.bodies, ctx.group, sweep_->bounds);
  sweep_->for_rigid(*rows_, ctx.group, [&](std::uint32_t k, bool excess) {
    sweep_->bounds[k] -= carried_[k];
    if (excess) sweep_->bounds[k] = std::max(0.0, sweep_->bounds[k]);
  });
}

double ClothBlock::project_displacement(const SubstepContext& ctx) {
  const int sweeps = sweeps_now();
  if (sweeps > 0) sweep_->run(*rows_, ctx, sweep_->bounds, sweeps, true);
  return 0.0;
}

void ClothBlock::end_displacement(const SubstepContext& ctx) {
  sweep_->follow(*rows_, ctx);
  std::vector<double>& held = sweep_->bounds;
  sweep_->for_rigid(*rows_, ctx.group, [&](std::uint32_t k, bool) { carried_[k] = -held[k]; });
  sweep_->violations(*rows_, ctx.bodies, ctx.group, held);
  sweep_->for_rigid(*rows_, ctx.group, [&](std::uint32_t k, bool excess) {
    carried_[k] += held[k];
    if (excess) carried_[k] = std::max(0.0, carried_[k]);
  });
}

void ClothBlock::end_step(const SubstepContext& ctx, std::span<double> /*wanted*/) {
  residual_ = 0.0;
  sweep_->violations(*rows_, ctx.bodies, Sweep::kAllGroups, sweep_->bounds);
  sweep_->for_rigid(*rows_, Sweep::kAllGroups, [&](std::uint32_t k, bool excess) {
    const double c = sweep_->bounds[k];
    residual_ = std::max(residual_, excess ? c : std::abs(c));
    // A non-finite step must not spoil the next one.
    if (!std::isfinite(carried_[k])) carried_[k] = 0.0;
  });
}

void ClothBlock::append_edges(std::vector<ConstraintEdge>& edges) const {
  // No repeats: rows would return the kinetic energy of their stretch a second time.
  rows_->for_neighbours([&](BodyId a, BodyId b) {
    edges.push_back({.body_a = a.index, .body_b = b.index, .repeats = false});
  });
}

/// Pairs of neighbours, made on demand after rows have changed.
const ByBody& ClothBlock::neighbours() const {
  by_body_.renew([&] {
    std::uint32_t pair = 0;
    rows_->for_neighbours([&](BodyId a, BodyId b) { by_body_.add(pair++, a.index, b.index); });
  });
  return by_body_;
}

void ClothBlock::append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const {
  neighbours().for_rows(body, [&](std::uint32_t, std::uint32_t other) { joined.push_back(other); });
}

void ClothBlock::take_changed(std::vector<std::uint32_t>& bodies) {
  bodies.insert(bodies.end(), changed_.begin(), changed_.end());
  changed_.clear();
}

void ClothBlock::remove_body(BodyId body) {
  const std::size_t before = changed_.size();
  append_joined(body.index, changed_);
  if (changed_.size() == before) return;
  own_rows().erase(
      carried_, [](std::uint64_t) { return false; }, [&](BodyId id) { return id == body; });
}

BlockReport ClothBlock::report() const {
  double left = 0.0;
  for (const double value : carried_) left = std::max(left, std::abs(value));
  return {.name = kName,
          .rows = static_cast<int>(rows_->row_count()),
          .residual = residual_,
          .displacement_residual = left};
}

void ClothBlock::save(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(sweeps_));
  rows_->save(out);
  rows_->for_scalars([&](std::uint32_t at, std::uint32_t count) {
    for (std::uint32_t k = at; k < at + count; ++k) out.f64(carried_[k]);
  });
  out.u32(static_cast<std::uint32_t>(changed_.size()));
  for (const std::uint32_t body : changed_) out.u32(body);
}

void ClothBlock::load(ByteReader& in) {
  sweeps_ = static_cast<int>(in.u32());
  if (sweeps_ < 1 || sweeps_ > 100) in.fail();
  rows_ = std::make_shared<ClothRows>();
  by_body_.outdate();
  rows_->load(in);
  carried_.assign(in.failed() ? 0 : rows_->number(), 0.0);
  for (double& value : carried_) {
    value = in.f64();
    if (!std::isfinite(value)) in.fail();
  }
  changed_.clear();
  const std::uint32_t count = in.u32();
  for (std::uint32_t i = 0; i < count && !in.failed(); ++i) changed_.push_back(in.u32());
  if (in.failed()) {
    *rows_ = {};
    carried_.clear();
    changed_.clear();
  }
}

bool ClothBlock::fits(const World& world) const { return rows_->fits(world); }

std::unique_ptr<ConstraintBlock> ClothBlock::make_empty() const {
  return std::make_unique<ClothBlock>();
}

bool ClothBlock::assign(const ConstraintBlock& source) {
  const auto* other = dynamic_cast<const ClothBlock*>(&source);
  if (other == nullptr) return false;
  rows_ = other->rows_;
  by_body_.outdate();
  carried_ = other->carried_;
  changed_ = other->changed_;
  sweeps_ = other->sweeps_;
  residual_ = other->residual_;
  return true;
}

}  // namespace tandem::pbd
