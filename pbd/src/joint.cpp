// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/joint.h"

#include <algorithm>
#include <string>
#include <vector>

#include "joint_impl.h"
#include "joint_motor.h"
#include "joint_spring.h"

namespace tandem::pbd {
namespace {

/// rad, largest turn of a joint's bodies against each other in a substep.
constexpr double kTurn = 0.07;
/// Steps by which spin is extrapolated from its last change, so that a whipping chain has its
/// substeps before it needs them. Changes by contacts are not extrapolated.
constexpr double kAhead = 2.0;

/// rad/s, of b relative to a.
Vec3 relative_spin(const SixDofJointDef& def, std::span<const SolverBody> bodies) {
  const Vec3& w_b = bodies[def.b.index].w;
  return def.a.valid() ? Vec3(w_b - bodies[def.a.index].w) : w_b;
}

/// Whether later rows have moved one of its ends in this step.
bool is_pushed(const JointRecord& record, std::span<const SolverBody> bodies) {
  const auto pushed = [&](BodyId id) { return id.valid() && bodies[id.index].is_pushed(); };
  return pushed(record.def.a) || pushed(record.def.b);
}

/// Implementation of JointBlock::end_step().
void want_substeps(std::span<const JointRecord> records, const SubstepContext& ctx,
                   std::span<double> wanted) {
  for (const JointRecord& record : records) {
    if (!record.active()) continue;
    const Vec3 spin = relative_spin(record.def, ctx.bodies);
    double fastest = spin.norm();
    if (!is_pushed(record, ctx.bodies))
      fastest = std::max(fastest, (spin + kAhead * (spin - record.before.spin)).norm());
    const double most = ctx.h / kTurn * fastest;
    for (const BodyId body : {record.def.a, record.def.b}) {
      if (body.valid()) wanted[body.index] = std::max(wanted[body.index], most);
    }
  }
}

/// A body at its pose before the step; the invalid id gives the world.
SolverBody standing(const World& world, BodyId id) {
  SolverBody body;
  if (!id.valid()) return body;
  body.x = world.pose(id).position;
  body.q = world.pose(id).orientation;
  return body;
}

}  // namespace

JointBlock::JointBlock() : impl_(std::make_unique<Impl>()) {}
JointBlock::~JointBlock() = default;

JointId JointBlock::add(const World& world, const SixDofJointDef& def) {
  check_joint(world, def);
  JointRecord record;
  record.assign(def);
  record.alive = true;
  weigh_springs(record, world);
  record.start(standing(world, def.a), standing(world, def.b));
  impl_->dirty = true;
  impl_->note_change(record);
  ++impl_->count;
  auto index = static_cast<std::uint32_t>(impl_->records.size());
  if (!impl_->free.empty()) {
    index = impl_->free.back();
    impl_->free.pop_back();
    impl_->records[index] = record;
  } else {
    impl_->records.push_back(record);
    impl_->generations.push_back(0);
    impl_->free.reserve(impl_->records.size());
  }
  impl_->by_body.add(index, def.a.index, def.b.index);
  return {index, impl_->generations[index]};
}

bool JointBlock::contains(JointId id) const { return impl_->contains(id); }
void JointBlock::remove(JointId id) { impl_->erase(impl_->checked(id)); }

void JointBlock::set(const World& world, JointId id, const SixDofJointDef& def) {
  JointRecord& record = impl_->records[impl_->checked(id)];
  check_joint(world, def);
  detail::require(def.a == record.def.a, "joint", "a", def.a.index, "the body it was added with");
  detail::require(def.b == record.def.b, "joint", "b", def.b.index, "the body it was added with");
  const int turned = record.turning;
  record.assign(def);
  weigh_springs(record, world);
  if (record.turning != turned)
    record.twist = record.state.position[static_cast<std::size_t>(record.turn(0))];
  impl_->note_change(record);
}

void JointBlock::set_enabled(JointId id, bool enabled) {
  JointRecord& record = impl_->records[impl_->checked(id)];
  record.def.enabled = enabled;
  impl_->note_change(record);
  if (enabled) record.state.broken = false;
}

const SixDofJointDef& JointBlock::def(JointId id) const {
  return impl_->records[impl_->checked(id)].def;
}
const JointState& JointBlock::at(JointId id) const {
  return impl_->records[impl_->checked(id)].state;
}

namespace {

/// Refuses joints that leave other coordinates free than this one.
void require_only_free(const SixDofJointDef& def, std::size_t coordinate, JointId id,
                       const char* field, const char* rule) {
  for (std::size_t i = 0; i < 6; ++i) {
    const JointAxis& axis = i < 3 ? def.linear[i] : def.angular[i - 3];
    const bool locked = axis.freedom == Freedom::Locked;
    if (locked == (i == coordinate))
      detail::refuse(field, rule, "joint " + std::to_string(id.index));
  }
}

}  // namespace

double JointBlock::hinge_angle(JointId id) const {
  require_only_free(def(id), 3, id, "JointBlock::hinge_angle: id", "a hinge");
  return at(id).position[3];
}
double JointBlock::slider_position(JointId id) const {
  require_only_free(def(id), 0, id, "JointBlock::slider_position: id", "a slider");
  return at(id).position[0];
}
int JointBlock::size() const { return impl_->count; }

std::vector<JointId> joint_ids(const JointBlock& block) {
  std::vector<JointId> ids;
  for (std::uint32_t i = 0; i < block.impl_->records.size(); ++i) {
    if (block.impl_->records[i].alive) ids.push_back({i, block.impl_->generations[i]});
  }
  return ids;
}
bool JointBlock::empty() const { return impl_->count == 0; }
bool JointBlock::has_gaps() const { return impl_->gaps; }

void JointBlock::take_changed(std::vector<std::uint32_t>& bodies) {
  bodies.insert(bodies.end(), impl_->changed.begin(), impl_->changed.end());
  impl_->changed.clear();
}

void JointBlock::begin_step(const SubstepContext& ctx) {
  impl_->find_gaps(ctx);
  if (impl_->dirty || impl_->natural != ctx.order.natural() ||
      !impl_->system.fits(impl_->records, ctx.bodies)) {
    impl_->system.build(impl_->records, ctx.bodies, ctx.order);
    impl_->dirty = false;
    impl_->natural = ctx.order.natural();
  }
  impl_->system.sort_groups(ctx.bodies);
  impl_->system.note_passive(impl_->records);
  for (JointRecord& record : impl_->records) {
    record.broke = false;
    record.in_part = 0;
    record.before.twist = record.twist;
    if (record.active()) record.before.spin = relative_spin(record.def, ctx.bodies);
  }
}

void JointBlock::begin_substep(const SubstepContext& ctx) {
  impl_->system.for_parts(ctx.group, false, [&](std::uint32_t part) {
    impl_->system.begin(part, impl_->records, ctx, JointChannel::Real);
  });
}

double JointBlock::project(const SubstepContext& ctx) {
  double largest = 0.0;
  impl_->system.for_parts(ctx.group, ctx.reverse, [&](std::uint32_t part) {
    largest = std::max(largest, impl_->system.iterate(part, impl_->records, ctx));
  });
  return largest;
}

void JointBlock::finish_projection(const SubstepContext& ctx) {
  impl_->system.for_parts(ctx.group, false, [&](std::uint32_t part) {
    impl_->system.finish_projection(part, impl_->records, ctx);
  });
}

void JointBlock::finish_velocity(const SubstepContext& ctx) {
  impl_->system.for_parts(ctx.group, false, [&](std::uint32_t part) {
    impl_->system.finish(part, impl_->records, ctx);
  });
}

void JointBlock::begin_displacement(const SubstepContext& ctx) {
  impl_->for_shared(ctx, [&](JointRecord& record) {
    const SolverBody ground;
    record.aim(body_of(record.def.a, ctx.bodies, ground), ctx.bodies[record.def.b.index], ctx.h);
  });
  impl_->system.for_parts(ctx.group, false, [&](std::uint32_t part) {
    if (!impl_->system.is_shared(part, ctx.bodies)) return;
    impl_->system.begin(part, impl_->records, ctx, JointChannel::Displacement);
  });
}

double JointBlock::project_displacement(const SubstepContext& ctx) {
  double largest = 0.0;
  impl_->system.for_parts(ctx.group, ctx.reverse, [&](std::uint32_t part) {
    if (!impl_->system.is_shared(part, ctx.bodies)) return;
    largest = std::max(largest, impl_->system.iterate(part, impl_->records, ctx));
  });
  return largest;
}

void JointBlock::end_displacement(const SubstepContext& ctx) {
  impl_->for_shared(ctx, [&](JointRecord& record) {
    double c[kCoordinates] = {};
    impl_->place(record, ctx.bodies, c);
    for (int i = 0; i < kCoordinates; ++i) {
      double& residual = record.displacement_residual[i];
      residual = gap_left(record.axis(i), c[i], record.bound[i], residual);
    }
  });
}

void JointBlock::end_step(const SubstepContext& ctx, std::span<double> wanted) {
  if (!wanted.empty()) want_substeps(impl_->records, ctx, wanted);
  for (JointRecord& record : impl_->records) {
    if (!record.alive) continue;
    if (record.broke) impl_->apart_known = false;
    JointState& state = record.state;
    double c[kCoordinates] = {};
    const SolverBody ground;
    const SolverBody& body_a = body_of(record.def.a, ctx.bodies, ground);
    all_coordinates(record, body_a, ctx.bodies[record.def.b.index], record.twist, c);
    const auto is_finite = [](double value) { return std::isfinite(value); };
    if (!std::all_of(c, c + kCoordinates, is_finite) || !state.force.allFinite() ||
        !state.torque.allFinite()) {
      // Non-finite step: bodies return to its start, and so does the joint.
      record.twist = record.before.twist;
      record.energy_excess = 0.0;
      record.displacement_residual.fill(0.0);
      record.clear_forces();
      record.last.rotors_known = false;
      continue;
    }
    record.tell(body_a, c);
    state.residual = 0.0;
    if ((!record.active() && !record.broke) || !Impl::is_solved(record, ctx.bodies)) {
      record.clear_forces();
      record.last.rotors_known = false;
    }
    if (!record.active()) continue;
    const bool left = is_pushed(record, ctx.bodies);
    for_bits(record.used, [&](int i) {
      const JointAxis& axis = record.axis(i);
      state.residual = std::max(state.residual, violation(axis, c[i]));
      double& residual = record.displacement_residual[i];
      if ((record.in_part >> i & 1u) != 0) {
        residual = residual_of(axis, c[i]);
        if (std::abs(residual) > JointGap::kTolerance) record.gap.open(std::abs(residual));
        return;
      }
      if (!left) return;
      residual = residual_of(axis, c[i]);
      if (std::abs(residual) > kLeft) record.gap.open(std::abs(residual));
    });
    // A non-finite step must not spoil the next one.
    if (!std::isfinite(record.energy_excess)) record.energy_excess = 0.0;
    for (double& residual : record.displacement_residual) {
      if (!std::isfinite(residual)) residual = 0.0;
    }
    record.settle_gap();
  }
}

void JointBlock::append_edges(std::vector<ConstraintEdge>& edges) const {
  for (const JointRecord& record : impl_->records) {
    if (!record.active()) continue;
    const bool force_driven = !record.passive;
    const bool actuated = force_driven && motors_run(record);
    edges.push_back({.body_a = record.def.a.index,
                     .body_b = record.def.b.index,
                     .actuated = actuated,
                     .force_driven = force_driven});
  }
}

void JointBlock::append_idle(std::vector<ConstraintEdge>& edges) const {
  for (const JointRecord& record : impl_->records) {
    if (!record.alive || record.active()) continue;
    edges.push_back({.body_a = record.def.a.index, .body_b = record.def.b.index});
  }
}

void JointBlock::append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const {
  impl_->named().for_rows(body, [&](std::uint32_t row, std::uint32_t other) {
    if (impl_->records[row].active() && other != BodyId::kNone) joined.push_back(other);
  });
}

void JointBlock::append_apart(std::vector<BodyPair>& pairs) const {
  const std::vector<BodyPair>& apart = impl_->kept_apart();
  pairs.insert(pairs.end(), apart.begin(), apart.end());
}

void JointBlock::remove_body(BodyId body) {
  for (const std::uint32_t row : impl_->named().rows_of(body.index)) impl_->erase(row);
}

BlockReport JointBlock::report() const {
  BlockReport report{.name = name(), .rows = impl_->count};
  for (const JointRecord& record : impl_->records) {
    if (!record.active()) continue;
    report.residual = std::max(report.residual, record.state.residual);
    for (const double residual : record.displacement_residual) {
      report.displacement_residual = std::max(report.displacement_residual, std::abs(residual));
    }
  }
  return report;
}

void JointBlock::save(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(impl_->records.size()));
  for (std::size_t i = 0; i < impl_->records.size(); ++i) {
    out.u32(impl_->generations[i]);
    impl_->records[i].save(out);
  }
  out.u32(static_cast<std::uint32_t>(impl_->free.size()));
  for (const std::uint32_t index : impl_->free) out.u32(index);
  out.u32(static_cast<std::uint32_t>(impl_->changed.size()));
  for (const std::uint32_t body : impl_->changed) out.u32(body);
}

void JointBlock::load(ByteReader& in) {
  const std::uint32_t size = in.u32();
  impl_->records.clear();
  impl_->generations.clear();
  impl_->free.clear();
  impl_->by_body.outdate();  // rebuilt later: the input may name bodies that do not exist
  impl_->count = 0;
  std::vector<std::uint8_t> alive;
  for (std::uint32_t i = 0; i < size && !in.failed(); ++i) {
    impl_->generations.push_back(in.u32());
    impl_->records.emplace_back();
    impl_->records.back().load(in);
    if (impl_->records.back().alive) ++impl_->count;
    alive.push_back(impl_->records.back().alive ? 1 : 0);
  }
  const std::uint32_t free_count = in.u32();
  impl_->free.reserve(impl_->records.size());
  for (std::uint32_t i = 0; i < free_count && !in.failed(); ++i) impl_->free.push_back(in.u32());
  if (!detail::are_free_slots(impl_->free, alive)) in.fail();
  impl_->changed.clear();
  const std::uint32_t changed = in.u32();
  for (std::uint32_t i = 0; i < changed && !in.failed(); ++i) impl_->changed.push_back(in.u32());
  impl_->dirty = true;
  impl_->apart_known = false;
}

bool JointBlock::fits(const World& world) const {
  try {
    for (const JointRecord& record : impl_->records) {
      if (record.alive) check_joint(world, record.def);
    }
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

std::unique_ptr<ConstraintBlock> JointBlock::make_empty() const {
  return std::make_unique<JointBlock>();
}

bool JointBlock::assign(const ConstraintBlock& source) {
  const auto* other = dynamic_cast<const JointBlock*>(&source);
  if (other == nullptr) return false;
  // Copies the plan of the system too, which costs far more to make.
  *impl_ = *other->impl_;
  impl_->free.reserve(impl_->records.size());  // as in add(): removal must not allocate
  return true;
}

}  // namespace tandem::pbd
