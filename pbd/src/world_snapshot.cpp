// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A world as bytes: everything that the next step depends on.
#include <cmath>
#include <stdexcept>
#include <string>

#include "body_def.h"
#include "byte_fields.h"
#include "free_rotation.h"
#include "groups.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

constexpr std::uint32_t kSnapshotMagic = 0x53444e54;  // "TNDS"
constexpr std::uint32_t kSnapshotVersion = 15;

/// Bytes before the state, and after it: see snapshot().
constexpr std::size_t kHeadBytes = 4 + 4 + 4 + 8 + 1;
constexpr std::size_t kCheckBytes = 8;

/// Bytes of one slot: head, properties, activity, state.
constexpr std::size_t kBytesPerSlot =
    (1 + 4 + 1) + (1 + 5 * 8 + 6 + 2 + 18 * 8 + 1 + 8 + 5 * 8) + (1 + 1 + 4 + 8) + 13 * 8;

// Lists fields for saving or loading.
void props_fields(auto& io, auto& props) {
  io(props.type, props.mass, props.inverse_mass, props.gravity_scale, props.linear_damping,
     props.angular_damping, props.locks.linear, props.locks.angular, props.bullet, props.can_sleep,
     props.inertia, props.inverse_inertia);
}
void state_fields(auto& io, auto& state) { io(state.pose, state.twist); }
void wrench_fields(auto& io, auto& wrench) { io(wrench.force, wrench.torque); }
void target_fields(auto& io, auto& target) { io(target.index, target.pose); }
void correction_fields(auto& io, auto& correction) {
  io(correction.translation, correction.rotation, correction.twist);
}

void save_body(FieldWriter io, const BodyProps& props, const BodyActivity& activity,
               const BodyState& state) {
  props_fields(io, props);
  io(props.stable_id.has_value(), props.stable_id.value_or(0), props.origin);
  io(props.sleep_speed.value_or(-1.0), props.sleep_spin.value_or(-1.0));
  io(!activity.asleep, activity.level, std::uint32_t{activity.steps_at_lower_level},
     activity.low_speed_time, activity.moved, activity.turned);
  state_fields(io, state);
}

void load_body(FieldReader io, BodyProps& props, BodyActivity& activity, BodyState& state) {
  props_fields(io, props);
  bool named = false;
  std::uint64_t id = 0;
  io(named, id, props.origin);
  props.stable_id = named ? std::optional(id) : std::nullopt;
  double speed = 0.0;
  double spin = 0.0;
  io(speed, spin);
  props.sleep_speed = speed == -1.0 ? std::nullopt : std::optional(speed);
  props.sleep_spin = spin == -1.0 ? std::nullopt : std::optional(spin);
  std::uint32_t steps = 0;
  bool awake = true;
  io(awake, activity.level, steps, activity.low_speed_time, activity.moved, activity.turned);
  activity.asleep = !awake;
  activity.steps_at_lower_level = static_cast<std::uint16_t>(steps);
  state_fields(io, state);
}

/// Whether the state is valid for a body; that of an empty slot is, too.
bool body_is_sound(const BodyProps& props, const BodyActivity& activity, const BodyState& state) {
  const bool dynamic = props.type == BodyType::Dynamic;
  if (props.type > BodyType::Dynamic || activity.level > Groups::kMaxLevel ||
      !(activity.low_speed_time >= 0.0) || !activity.moved.allFinite() ||
      !activity.turned.allFinite() || dynamic != (props.inverse_mass > 0.0) ||
      !std::isfinite(props.mass) || !std::isfinite(props.inverse_mass) ||
      !props.inertia.allFinite() || !props.inverse_inertia.allFinite()) {
    return false;
  }
  try {
    check_def({.type = props.type,
               .pose = state.pose,
               .twist = state.twist,
               .mass = props.mass,
               .inertia = props.inertia,
               .gravity_scale = props.gravity_scale,
               .linear_damping = props.linear_damping,
               .angular_damping = props.angular_damping,
               .sleep_speed = props.sleep_speed,
               .sleep_spin = props.sleep_spin,
               .origin = props.origin});
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

/// Hash of the kinds of constraints of a world, in order: snapshots of other kinds do not fit.
std::uint64_t kinds_of(std::span<const std::unique_ptr<ConstraintBlock>> blocks) {
  std::uint64_t hash = hash_bytes({});
  for (const auto& block : blocks) {
    const std::string_view name = block->name();
    hash = hash_bytes(std::as_bytes(std::span(name.data(), name.size())), hash);
  }
  return hash;
}

/// One per slot, or none.
bool load_wrenches(ByteReader& in, std::uint32_t slots, std::vector<Wrench>& wrenches) {
  const std::uint32_t count = in.u32();
  if (in.failed() || (count != 0 && count != slots)) return false;
  wrenches.assign(count, {});
  FieldReader io(in);
  for (Wrench& wrench : wrenches) {
    wrench_fields(io, wrench);
    if (!wrench.force.allFinite() || !wrench.torque.allFinite()) return false;
  }
  return true;
}

bool load_targets(ByteReader& in, const PropsTable& props, KinematicTargets& targets) {
  const std::uint32_t count = in.u32();
  if (in.failed() || count > props.size()) return false;
  targets.clear();
  FieldReader io(in);
  for (std::uint32_t i = 0; i < count; ++i) {
    KinematicTarget target;
    target_fields(io, target);
    if (target.index >= props.size() || props[target.index].type != BodyType::Kinematic ||
        !target.pose.position.allFinite() ||
        !(std::abs(target.pose.orientation.norm() - 1.0) < 1e-3)) {
      return false;
    }
    targets.set(target);
  }
  return true;
}

/// One per slot, or none.
bool load_corrections(ByteReader& in, std::uint32_t slots, std::vector<Correction>& corrections) {
  const std::uint32_t count = in.u32();
  if (in.failed() || (count != 0 && count != slots)) return false;
  corrections.assign(count, {});
  FieldReader io(in);
  for (Correction& correction : corrections) correction_fields(io, correction);
  return true;
}

}  // namespace

std::vector<std::byte> World::snapshot() const {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  FieldWriter io(out);
  out.u32(kSnapshotMagic);
  out.u32(kSnapshotVersion);
  out.u32(static_cast<std::uint32_t>(blocks_.size()));
  out.u64(kinds_of(blocks_));
  out.u8(contact_source_ != nullptr ? 1 : 0);
  out.vec3(gravity_);
  out.f64(time_);
  out.u32(slot_count());
  for (std::uint32_t i = 0; i < slot_count(); ++i) {
    slots_.save_slot(out, i);
    out.u8(in_contact_[i]);
    save_body(io, props_[i], activity_[i], states_[i]);
  }
  slots_.save_free(out);
  out.u32(static_cast<std::uint32_t>(wrenches_.size()));
  for (const Wrench& wrench : wrenches_) wrench_fields(io, wrench);
  out.u32(static_cast<std::uint32_t>(kinematic_targets().size()));
  for (const KinematicTarget& target : kinematic_targets()) target_fields(io, target);
  out.u32(static_cast<std::uint32_t>(corrections_.size()));
  for (const Correction& correction : corrections_) correction_fields(io, correction);
  for (const auto& block : blocks_) block->save(out);
  if (contact_source_ != nullptr) contact_source_->save(out);
  out.u64(hash_bytes(bytes));
  return bytes;
}

void World::restore(std::span<const std::byte> bytes) {
  const auto refuse = [](const char* rule) { detail::refuse("World::restore: bytes", rule); };
  // The checksum comes first: it detects damage, but not forged bytes.
  if (bytes.size() < kCheckBytes) refuse("whole");
  const auto content = bytes.first(bytes.size() - kCheckBytes);
  if (ByteReader(bytes.last(kCheckBytes)).u64() != hash_bytes(content)) refuse("whole");
  ByteReader in(content);
  if (in.u32() != kSnapshotMagic || in.u32() != kSnapshotVersion) {
    refuse("a snapshot of this version");
  }
  if (in.u32() != blocks_.size() || in.u64() != kinds_of(blocks_) ||
      (in.u8() != 0) != (contact_source_ != nullptr)) {
    refuse("taken from a world with the same blocks and contact source");
  }
  const std::vector<std::byte> before = snapshot();
  if (read(in)) return;
  const std::span<const std::byte> kept(before);
  ByteReader back(kept.subspan(kHeadBytes, kept.size() - kHeadBytes - kCheckBytes));
  read(back);
  refuse("the state of a world that has these blocks and colliders");
}

bool World::read(ByteReader& in) {
  placements_.note();
  body_log_.outdate();
  gravity_ = in.vec3();
  time_ = in.f64();
  const std::uint32_t slots = in.u32();
  if (in.failed() || slots > in.remaining() / kBytesPerSlot || !gravity_.allFinite() ||
      !std::isfinite(time_)) {
    return false;
  }
  states_.assign(slots, {});
  props_ = {};
  props_.resize(slots);
  slots_.clear();
  in_contact_.assign(slots, 0);
  touching_.clear();
  activity_.resize(0);
  activity_.resize(slots);
  by_stable_id_.clear();
  order_is_old_ = true;
  for (std::uint32_t i = 0; i < slots; ++i) {
    slots_.load_slot(in);
    in_contact_[i] = in.u8();
    if (in_contact_[i] != 0) touching_.push_back(i);
    BodyProps props;
    load_body(FieldReader(in), props, activity_[i], states_[i]);
    if (!body_is_sound(props, activity_[i], states_[i])) return false;
    if (props.type == BodyType::Dynamic) props.principal = principal_axes(props.inertia);
    props_.set(i, props);
    if (!props_[i].stable_id) continue;
    if (!slots_.alive(i) || !by_stable_id_.emplace(*props_[i].stable_id, i).second) return false;
  }
  slots_.load_free(in);
  if (!load_wrenches(in, slots, wrenches_) || !load_targets(in, props_, kinematic_targets_) ||
      !load_corrections(in, slots, corrections_)) {
    return false;
  }
  for (const auto& block : blocks_) block->load(in);
  if (contact_source_ != nullptr) contact_source_->load(in);
  if (in.failed() || in.remaining() != 0) return false;
  for (const auto& block : blocks_) {
    if (!block->fits(*this)) return false;
  }
  return contact_source_ == nullptr || contact_source_->fits(*this);
}

std::uint64_t World::hash() const {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  FieldWriter io(out);
  for (std::uint32_t i = 0; i < slot_count(); ++i) {
    if (!slots_.alive(i)) continue;
    out.u32(i);
    state_fields(io, states_[i]);
  }
  return hash_bytes(bytes);
}

}  // namespace tandem::pbd
