// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "part.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "shape_record.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"

namespace tandem::mpi {
namespace {

// Layout of a manifold's key in CollisionScene.
constexpr int kClusterBits = 12;
constexpr int kIndexBits = 26;
constexpr std::uint64_t kClusterMask = (std::uint64_t{1} << kClusterBits) - 1;
constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << kIndexBits) - 1;

/// Bound on the colliders of one body.
constexpr std::uint32_t kMaxColliders = 1u << 20;

pbd::BodyDef def_of(const pbd::World& world, std::uint32_t slot) {
  const pbd::BodyProps& props = world.all_props()[slot];
  pbd::BodyDef def;
  def.type = props.type;
  def.pose = world.states()[slot].pose;
  def.twist = world.states()[slot].twist;
  def.mass = props.mass;
  def.inertia = props.inertia;
  def.gravity_scale = props.gravity_scale;
  def.linear_damping = props.linear_damping;
  def.angular_damping = props.angular_damping;
  def.locks = props.locks;
  def.bullet = props.bullet;
  def.can_sleep = props.can_sleep;
  def.sleep_speed = props.sleep_speed;
  def.sleep_spin = props.sleep_spin;
  def.stable_id = props.stable_id;
  def.origin = props.origin;
  def.user_data = world.user_data(world.body_at(slot));
  return def;
}

}  // namespace

void write_state(const pbd::BodyState& state, MessageWriter& out) {
  out.vec3(state.pose.position);
  out.quat(state.pose.orientation);
  out.vec3(state.twist.linear);
  out.vec3(state.twist.angular);
}

pbd::BodyState read_state(MessageReader& in) {
  pbd::BodyState state;
  state.pose.position = in.vec3();
  state.pose.orientation = in.quat();
  state.twist.linear = in.vec3();
  state.twist.angular = in.vec3();
  return state;
}

void write_activity(const pbd::BodyActivity& activity, MessageWriter& out) {
  out.put<std::uint8_t>(activity.asleep ? 0 : 1);
  out.put(activity.level);
  out.put(activity.steps_at_lower_level);
  if (activity.asleep) return;  // sleeping bodies start over when they wake
  out.put(activity.low_speed_time);
  out.vec3(activity.moved);
  out.vec3(activity.turned);
}

pbd::BodyActivity read_activity(MessageReader& in) {
  pbd::BodyActivity activity;
  activity.asleep = in.get<std::uint8_t>() == 0;
  activity.level = in.get<std::uint8_t>();
  activity.steps_at_lower_level = in.get<std::uint16_t>();
  if (activity.asleep) return activity;
  activity.low_speed_time = in.get<double>();
  activity.moved = in.vec3();
  activity.turned = in.vec3();
  return activity;
}

void write_contact(const NamedContact& named, MessageWriter& out) {
  out.put(named.a);
  out.put(named.b);
  out.put(named.collider_a);
  out.put(named.collider_b);
  out.put(named.cluster);
  Bytes record;
  pbd::ByteWriter writer(record);
  named.contact.save(writer);
  out.record(record);
}

NamedContact read_contact(MessageReader& in) {
  NamedContact named;
  named.a = in.get<BodyName>();
  named.b = in.get<BodyName>();
  named.collider_a = in.get<std::uint32_t>();
  named.collider_b = in.get<std::uint32_t>();
  named.cluster = in.get<std::uint32_t>();
  pbd::ByteReader record(in.record());
  named.contact.load(record);
  if (record.failed()) in.fail();
  return named;
}

pbd::BodyId Part::insert(const pbd::BodyDef& def, std::span<const collision::ColliderDef> colliders,
                         BodyName name, bool copy) {
  const pbd::BodyId body = world_.add_body(def);
  const std::uint32_t slot = body.index;
  if (slot >= names_.size()) {
    names_.resize(slot + 1, kFixed);
    copies_.resize(slot + 1, 0);
    radii_.resize(slot + 1, 0.0);
    surfaces_.resize(slot + 1, 0);
    colliders_.resize(slot + 1);
  }
  names_[slot] = name;
  copies_[slot] = copy ? 1 : 0;
  radii_[slot] = 0.0;
  surfaces_[slot] = 0;
  colliders_[slot].clear();
  own_is_old_ = true;
  if (is_own(slot)) ++exchanged_;
  try {
    for (collision::ColliderDef collider : colliders) {
      collider.body = body;
      collider.passive = copy;
      colliders_[slot].push_back(shapes_.add(world_, collider));
      radii_[slot] = std::max(radii_[slot], reach_of(collider));
      if (is_surface(collider.shape)) surfaces_[slot] = 1;
    }
  } catch (...) {
    remove(slot);
    throw;
  }
  return body;
}

pbd::BodyId Part::add(const pbd::BodyDef& def, std::span<const collision::ColliderDef> colliders) {
  if (def.type != pbd::BodyType::Dynamic) {
    const pbd::BodyId body = insert(def, colliders, kFixed + fixed_.size(), false);
    fixed_.push_back(body.index);
    return body;
  }
  if (!def.stable_id || *def.stable_id >= kFixed) {
    pbd::detail::refuse("Cluster::add: stable_id", "given, and below 2^63, for a dynamic body");
  }
  for (const collision::ColliderDef& collider : colliders) {
    if (can_move(collider.shape, hulls_)) continue;
    pbd::detail::refuse(
        "Cluster::add: shape",
        "a sphere, box, capsule, cylinder, cone or a hull of use() for a dynamic body");
  }
  return insert(def, colliders, *def.stable_id, false);
}

void Part::remove(std::uint32_t slot) {
  // Here, as PartContacts does not remove them.
  for (const collision::ColliderId id : colliders_[slot]) shapes_.remove(id);
  colliders_[slot].clear();
  if (is_own(slot)) ++exchanged_;
  names_[slot] = kFixed;
  copies_[slot] = 0;
  own_is_old_ = true;
  world_.remove_body(world_.body_at(slot));
}

std::uint32_t Part::slot_of(BodyName name) const {
  if ((name & kFixed) != 0) {
    const std::uint64_t place = name & ~kFixed;
    return place < fixed_.size() ? fixed_[place] : pbd::BodyId::kNone;
  }
  return world_.find(name).index;
}

const std::vector<std::uint32_t>& Part::own() const {
  if (!own_is_old_) return own_;
  own_is_old_ = false;
  own_.clear();
  const pbd::BodyOrder order = world_.order();
  const auto count = world_.slot_count();
  for (std::uint32_t rank = 0; rank < count; ++rank) {
    const std::uint32_t slot = order.slot(rank);
    if (world_.body_at(slot).valid() && is_own(slot)) own_.push_back(slot);
  }
  return own_;
}

void Part::write(std::uint32_t slot, Bytes& bytes) const {
  MessageWriter out(bytes);
  const pbd::BodyDef def = def_of(world_, slot);
  out.put(def.stable_id.value_or(0));
  out.put(def.mass);
  out.doubles({def.inertia.data(), 9});
  out.put(def.gravity_scale);
  out.put(def.linear_damping);
  out.put(def.angular_damping);
  out.put(def.locks);
  out.put<std::uint8_t>(static_cast<std::uint8_t>((def.bullet ? 1 : 0) | (def.can_sleep ? 2 : 0)));
  out.put(def.sleep_speed.value_or(-1.0));
  out.put(def.sleep_spin.value_or(-1.0));
  out.put(def.user_data);
  out.doubles({def.origin.data(), 3});
  write_state(world_.states()[slot], out);
  write_activity(world_.activities()[slot], out);
  out.put(static_cast<std::uint32_t>(colliders_[slot].size()));
  for (const collision::ColliderId id : colliders_[slot]) {
    write_collider(shapes_.collider(id), hulls_, out);
  }
}

std::uint32_t Part::read(MessageReader& in, bool copy) {
  pbd::BodyDef def;
  def.stable_id = in.get<std::uint64_t>();
  def.mass = in.get<double>();
  for (int i = 0; i < 9; ++i) def.inertia.data()[i] = in.get<double>();
  def.gravity_scale = in.get<double>();
  def.linear_damping = in.get<double>();
  def.angular_damping = in.get<double>();
  def.locks = in.get<pbd::AxisLocks>();
  const auto flags = in.get<std::uint8_t>();
  def.bullet = (flags & 1) != 0;
  def.can_sleep = (flags & 2) != 0;
  const auto threshold = [&]() -> std::optional<double> {
    const auto value = in.get<double>();
    return value == -1.0 ? std::nullopt : std::optional(value);
  };
  def.sleep_speed = threshold();
  def.sleep_spin = threshold();
  def.user_data = in.get<std::uint64_t>();
  def.origin = in.vec3();
  const pbd::BodyState state = read_state(in);
  const pbd::BodyActivity activity = read_activity(in);
  const auto count = in.get<std::uint32_t>();
  if (in.failed() || count > kMaxColliders || *def.stable_id >= kFixed) return pbd::BodyId::kNone;
  std::vector<collision::ColliderDef> colliders(count);
  for (collision::ColliderDef& collider : colliders) {
    if (!read_collider(in, hulls_, collider)) return pbd::BodyId::kNone;
  }
  try {
    def.pose = state.pose;
    const pbd::BodyId body = insert(def, colliders, *def.stable_id, copy);
    world_.resume(body, state, activity);
    return body.index;
  } catch (const std::invalid_argument&) {
    return pbd::BodyId::kNone;
  }
}

std::uint32_t Part::ordinal(std::uint32_t slot, std::uint32_t collider) const {
  const auto& own = colliders_[slot];
  const auto at =
      std::find_if(own.begin(), own.end(), [&](const auto& id) { return id.index == collider; });
  return static_cast<std::uint32_t>(at - own.begin());
}

NamedContact Part::named(const pbd::Contact& contact) const {
  const pbd::Manifold& m = contact.manifold;
  auto low = static_cast<std::uint32_t>(m.key >> (kIndexBits + kClusterBits));
  auto high = static_cast<std::uint32_t>(m.key >> kClusterBits & kIndexMask);
  // Bodies may be ordered differently from colliders.
  if (ordinal(m.body_a, low) == colliders_[m.body_a].size()) std::swap(low, high);
  return {names_[m.body_a],
          names_[m.body_b],
          ordinal(m.body_a, low),
          ordinal(m.body_b, high),
          static_cast<std::uint32_t>(m.key & kClusterMask),
          contact};
}

bool Part::place(NamedContact& named) const {
  const std::uint32_t a = slot_of(named.a);
  const std::uint32_t b = slot_of(named.b);
  if (a == pbd::BodyId::kNone || b == pbd::BodyId::kNone ||
      named.collider_a >= colliders_[a].size() || named.collider_b >= colliders_[b].size()) {
    return false;
  }
  const std::uint64_t i = colliders_[a][named.collider_a].index;
  const std::uint64_t j = colliders_[b][named.collider_b].index;
  pbd::Manifold& m = named.contact.manifold;
  m.body_a = a;
  m.body_b = b;
  m.key = std::min(i, j) << (kIndexBits + kClusterBits) | std::max(i, j) << kClusterBits |
          named.cluster;
  return true;
}

}  // namespace tandem::mpi
