// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {
namespace {

constexpr std::uint32_t kSnapshotMagic = 0x53444e54;  // "TNDS"
constexpr std::uint32_t kSnapshotVersion = 2;

void check_pose(const Pose& pose, std::string_view kind) {
  detail::require_finite(pose.position, kind, "pose.position");
  const double norm = pose.orientation.norm();
  detail::require(std::abs(norm - 1.0) < 1e-3, kind, "pose.orientation", norm,
                  "a quaternion of unit norm (within 1e-3)");
}

void check_twist(const Twist& twist, std::string_view kind) {
  detail::require_finite(twist.linear, kind, "twist.linear");
  detail::require_finite(twist.angular, kind, "twist.angular");
}

void check_damping(double linear, double angular, std::string_view kind) {
  detail::require(linear >= 0.0 && std::isfinite(linear), kind, "linear_damping", linear,
                  "finite and >= 0");
  detail::require(angular >= 0.0 && std::isfinite(angular), kind, "angular_damping", angular,
                  "finite and >= 0");
}

/// Wakes what rows join to one body.
class Waker final : public LinkVisitor {
 public:
  Waker(std::uint32_t body, std::vector<std::uint32_t>& found) : body_(body), found_(found) {}
  void link(std::uint32_t a, std::uint32_t b) override {
    if (a == body_ && b != BodyId::kNone) found_.push_back(b);
    if (b == body_ && a != BodyId::kNone) found_.push_back(a);
  }

 private:
  std::uint32_t body_;
  std::vector<std::uint32_t>& found_;
};

void check_def(const BodyDef& def) {
  constexpr std::string_view kKind = "BodyDef";
  check_pose(def.pose, kKind);
  check_twist(def.twist, kKind);
  detail::require(std::isfinite(def.gravity_scale), kKind, "gravity_scale", def.gravity_scale,
                  "finite");
  check_damping(def.linear_damping, def.angular_damping, kKind);
  if (def.type != BodyType::Dynamic) return;
  detail::require(def.mass > 0.0 && std::isfinite(def.mass), kKind, "mass", def.mass,
                  "finite and > 0");
  detail::require(def.inertia.allFinite(), kKind, "inertia", def.inertia.sum(), "finite");
  const double asymmetry = (def.inertia - def.inertia.transpose()).cwiseAbs().maxCoeff();
  const double size = def.inertia.cwiseAbs().maxCoeff();
  detail::require(asymmetry <= 1e-9 * size, kKind, "inertia", asymmetry, "symmetric");
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(def.inertia, Eigen::EigenvaluesOnly);
  const Vec3& moments = eigen.eigenvalues();  // ascending
  detail::require(moments[0] > 0.0, kKind, "inertia", moments[0], "positive definite");
  detail::require(moments[0] + moments[1] >= moments[2] * (1.0 - 1e-6), kKind, "inertia",
                  moments[2], "largest moment at most the sum of the other two");
}

BodyProps make_props(const BodyDef& def) {
  BodyProps props;
  props.type = def.type;
  props.gravity_scale = def.gravity_scale;
  if (def.type == BodyType::Dynamic) {
    props.mass = def.mass;
    props.inverse_mass = 1.0 / def.mass;
    props.inertia_l = 0.5 * (def.inertia + def.inertia.transpose());
    props.inverse_inertia_l = props.inertia_l.inverse();
    props.linear_damping = def.linear_damping;
    props.angular_damping = def.angular_damping;
    props.locks = def.locks;
    props.bullet = def.bullet;
    props.can_sleep = def.can_sleep;
  }
  return props;
}

/// Which kinds of constraints a world holds, in order: a snapshot fits no other.
std::uint64_t kinds_of(std::span<const std::unique_ptr<ConstraintBlock>> blocks) {
  std::uint64_t hash = hash_bytes({});
  for (const auto& block : blocks) {
    const std::string_view name = block->name();
    hash = hash_bytes(std::as_bytes(std::span(name.data(), name.size())), hash);
  }
  return hash;
}

}  // namespace

namespace detail {

void require(bool ok, std::string_view kind, std::string_view field, double value,
             std::string_view rule) {
  if (ok) return;
  throw std::invalid_argument(std::string(kind) + ": " + std::string(field) + " = " +
                              std::to_string(value) + " breaks the rule: " + std::string(rule));
}

void require_finite(const Vec3& value, std::string_view kind, std::string_view field) {
  for (int i = 0; i < 3; ++i) require(std::isfinite(value[i]), kind, field, value[i], "finite");
}

void require_body(const World& world, BodyId id, std::string_view kind, std::string_view field) {
  if (world.contains(id)) return;
  throw std::invalid_argument(std::string(kind) + ": " + std::string(field) + " = body " +
                              std::to_string(id.index) + " (generation " +
                              std::to_string(id.generation) + ") names no body of this world");
}

}  // namespace detail

World::World(const WorldDef& def) { set_gravity(def.gravity); }
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

std::uint32_t World::checked_index(BodyId id, const char* what) const {
  detail::require_body(*this, id, "World", what);
  return id.index;
}

BodyId World::add_body(const BodyDef& def) {
  check_def(def);
  std::uint32_t index = 0;
  if (free_.empty()) {
    index = static_cast<std::uint32_t>(states_.size());
    states_.emplace_back();
    props_.emplace_back();
    generations_.push_back(0);
    alive_.push_back(0);
    in_contact_.push_back(0);
    activity_.emplace_back();
    if (!wrenches_.empty()) wrenches_.emplace_back();
    if (!corrections_.empty()) corrections_.emplace_back();
    free_.reserve(states_.size());
  } else {
    index = free_.back();
    free_.pop_back();
  }
  alive_[index] = 1;
  in_contact_[index] = 0;
  activity_[index] = {};
  if (!wrenches_.empty()) wrenches_[index] = {};
  if (!corrections_.empty()) corrections_[index] = {};
  props_[index] = make_props(def);
  states_[index].pose = def.pose;
  states_[index].pose.orientation.normalize();
  states_[index].twist = def.type == BodyType::Static ? Twist{} : def.twist;
  return {index, generations_[index]};
}

void World::remove_body(BodyId id) {
  const std::uint32_t index = checked_index(id, "remove_body");
  wake_joined(index);
  if (contact_source_ != nullptr) contact_source_->remove_body(id);
  for (const auto& block : blocks_) block->remove_body(id);
  alive_[index] = 0;
  ++generations_[index];
  activity_[index] = {};
  if (!wrenches_.empty()) wrenches_[index] = {};
  std::erase_if(kinematic_targets_, [&](const KinematicTarget& t) { return t.index == index; });
  props_[index] = {};
  states_[index] = {};
  free_.push_back(index);
}

bool World::contains(BodyId id) const {
  return id.index < states_.size() && alive_[id.index] != 0 &&
         generations_[id.index] == id.generation;
}

BodyId World::body_at(std::uint32_t index) const {
  if (index >= states_.size() || alive_[index] == 0) return {};
  return {index, generations_[index]};
}

std::uint32_t World::slot_count() const { return static_cast<std::uint32_t>(states_.size()); }
std::size_t World::body_count() const { return states_.size() - free_.size(); }

const BodyState& World::state(BodyId id) const { return states_[checked_index(id, "state")]; }
const BodyProps& World::props(BodyId id) const { return props_[checked_index(id, "props")]; }

void World::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t index = checked_index(id, "set_pose");
  check_pose(pose, "World::set_pose");
  wake(id);
  states_[index].pose = pose;
  states_[index].pose.orientation.normalize();
}

void World::set_twist(BodyId id, const Twist& twist) {
  const std::uint32_t index = checked_index(id, "set_twist");
  check_twist(twist, "World::set_twist");
  detail::require(props_[index].type != BodyType::Static ||
                      (twist.linear.isZero(0.0) && twist.angular.isZero(0.0)),
                  "World::set_twist", "twist", twist.linear.norm(), "zero for a static body");
  wake(id);
  states_[index].twist = twist;
}

std::uint32_t World::checked_dynamic(BodyId id, const char* what) const {
  const std::uint32_t index = checked_index(id, what);
  if (props_[index].type != BodyType::Dynamic) {
    throw std::invalid_argument(std::string("World::") + what + ": id = body " +
                                std::to_string(id.index) + " breaks the rule: a dynamic body");
  }
  return index;
}

void World::set_kinematic_target(BodyId id, const Pose& pose) {
  const std::uint32_t index = checked_index(id, "set_kinematic_target");
  check_pose(pose, "World::set_kinematic_target");
  detail::require(props_[index].type == BodyType::Kinematic, "World::set_kinematic_target", "id",
                  id.index, "a kinematic body");
  std::erase_if(kinematic_targets_, [&](const KinematicTarget& t) { return t.index == index; });
  kinematic_targets_.push_back({index, pose});
  kinematic_targets_.back().pose.orientation.normalize();
}

void World::set_damping(BodyId id, double linear, double angular) {
  const std::uint32_t index = checked_dynamic(id, "set_damping");
  check_damping(linear, angular, "World::set_damping");
  wake(id);
  props_[index].linear_damping = linear;
  props_[index].angular_damping = angular;
}

void World::set_gravity_scale(BodyId id, double scale) {
  const std::uint32_t index = checked_dynamic(id, "set_gravity_scale");
  detail::require(std::isfinite(scale), "World::set_gravity_scale", "scale", scale, "finite");
  wake(id);
  props_[index].gravity_scale = scale;
}

void World::set_locks(BodyId id, const AxisLocks& locks) {
  const std::uint32_t index = checked_dynamic(id, "set_locks");
  wake(id);
  props_[index].locks = locks;
}

Wrench& World::wrench_of(std::uint32_t index) {
  if (wrenches_.empty()) wrenches_.resize(states_.size());
  return wrenches_[index];
}

void World::apply_force(BodyId id, const Vec3& force) {
  const std::uint32_t index = checked_dynamic(id, "apply_force");
  detail::require_finite(force, "World::apply_force", "force");
  wake(id);
  wrench_of(index).force += force;
}

void World::apply_force(BodyId id, const Vec3& force, const Vec3& point_w) {
  const std::uint32_t index = checked_dynamic(id, "apply_force");
  detail::require_finite(force, "World::apply_force", "force");
  detail::require_finite(point_w, "World::apply_force", "point_w");
  wake(id);
  wrench_of(index).force += force;
  wrench_of(index).torque += (point_w - states_[index].pose.position).cross(force);
}

void World::apply_torque(BodyId id, const Vec3& torque) {
  const std::uint32_t index = checked_dynamic(id, "apply_torque");
  detail::require_finite(torque, "World::apply_torque", "torque");
  wake(id);
  wrench_of(index).torque += torque;
}

void World::apply_impulse(BodyId id, const Vec3& impulse, const Vec3& point_w) {
  const std::uint32_t index = checked_dynamic(id, "apply_impulse");
  detail::require_finite(impulse, "World::apply_impulse", "impulse");
  detail::require_finite(point_w, "World::apply_impulse", "point_w");
  states_[index].twist.linear += props_[index].inverse_mass * impulse;
  apply_angular_impulse(id, (point_w - states_[index].pose.position).cross(impulse));
}

void World::apply_angular_impulse(BodyId id, const Vec3& impulse) {
  const std::uint32_t index = checked_dynamic(id, "apply_angular_impulse");
  detail::require_finite(impulse, "World::apply_angular_impulse", "impulse");
  wake(id);
  const Pose& pose = states_[index].pose;
  states_[index].twist.angular +=
      tensor_to_world(pose.orientation, props_[index].inverse_inertia_l) * impulse;
}

bool World::awake(BodyId id) const { return activity_[checked_index(id, "awake")].awake; }

void World::wake(BodyId id) {
  const std::uint32_t index = checked_index(id, "wake");
  activity_[index].awake = true;
  activity_[index].still = 0.0;
  if (props_[index].type != BodyType::Dynamic) wake_joined(index);
}

void World::wake_joined(std::uint32_t index) {
  std::vector<std::uint32_t> joined;
  Waker waker(index, joined);
  for (const auto& block : blocks_) block->links(waker);
  for (const std::uint32_t other : joined) {
    activity_[other].awake = true;
    activity_[other].still = 0.0;
  }
}

void World::set_gravity(const Vec3& gravity) {
  detail::require_finite(gravity, "World", "gravity");
  gravity_ = gravity;
  for (BodyActivity& activity : activity_) {
    activity.awake = true;
    activity.still = 0.0;
  }
}

void World::insert_block(std::unique_ptr<ConstraintBlock> block) {
  // Equal orders keep the order in which they were added.
  const auto after = std::upper_bound(blocks_.begin(), blocks_.end(), block->order(),
                                      [](int order, const std::unique_ptr<ConstraintBlock>& other) {
                                        return order < other->order();
                                      });
  blocks_.insert(after, std::move(block));
}

void World::set_contact_source(ContactSource* source) {
  if (source != nullptr && contacts_ == nullptr) contacts_ = &add_block<ContactBlock>();
  contact_source_ = source;
}

Correction World::correction(BodyId id) const {
  const std::uint32_t index = checked_index(id, "correction");
  return corrections_.empty() ? Correction{} : corrections_[index];
}

bool World::in_contact(BodyId id) const {
  return in_contact_[checked_index(id, "in_contact")] != 0;
}

double World::kinetic_energy() const {
  double energy = 0.0;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (props_[i].inverse_mass == 0.0) continue;
    const Vec3 w_l = states_[i].pose.orientation.conjugate() * states_[i].twist.angular;
    energy += 0.5 * (props_[i].mass * states_[i].twist.linear.squaredNorm() +
                     w_l.dot(props_[i].inertia_l * w_l));
  }
  return energy;
}

double World::mechanical_energy() const {
  double energy = kinetic_energy();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    energy -= props_[i].mass * props_[i].gravity_scale * gravity_.dot(states_[i].pose.position);
  }
  return energy;
}

std::vector<std::byte> World::snapshot() const {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  out.u32(kSnapshotMagic);
  out.u32(kSnapshotVersion);
  out.u32(static_cast<std::uint32_t>(blocks_.size()));
  out.u64(kinds_of(blocks_));
  out.u8(contact_source_ != nullptr ? 1 : 0);
  out.vec3(gravity_);
  out.f64(time_);
  out.u32(slot_count());
  for (std::uint32_t i = 0; i < slot_count(); ++i) {
    out.u8(alive_[i]);
    out.u32(generations_[i]);
    out.u8(in_contact_[i]);
    out.u8(static_cast<std::uint8_t>(props_[i].type));
    out.f64(props_[i].mass);
    out.f64(props_[i].inverse_mass);
    out.f64(props_[i].gravity_scale);
    out.f64(props_[i].linear_damping);
    out.f64(props_[i].angular_damping);
    for (int k = 0; k < 3; ++k) out.u8(props_[i].locks.linear[k] ? 1 : 0);
    for (int k = 0; k < 3; ++k) out.u8(props_[i].locks.angular[k] ? 1 : 0);
    out.u8(props_[i].bullet ? 1 : 0);
    out.u8(props_[i].can_sleep ? 1 : 0);
    out.u8(activity_[i].awake ? 1 : 0);
    out.u8(activity_[i].level);
    out.u32(activity_[i].calm);
    out.f64(activity_[i].still);
    for (int k = 0; k < 9; ++k) out.f64(props_[i].inertia_l(k / 3, k % 3));
    for (int k = 0; k < 9; ++k) out.f64(props_[i].inverse_inertia_l(k / 3, k % 3));
    out.vec3(states_[i].pose.position);
    out.quat(states_[i].pose.orientation);
    out.vec3(states_[i].twist.linear);
    out.vec3(states_[i].twist.angular);
  }
  out.u32(static_cast<std::uint32_t>(free_.size()));
  for (const std::uint32_t index : free_) out.u32(index);
  out.u32(static_cast<std::uint32_t>(wrenches_.size()));
  for (const Wrench& wrench : wrenches_) {
    out.vec3(wrench.force);
    out.vec3(wrench.torque);
  }
  out.u32(static_cast<std::uint32_t>(kinematic_targets_.size()));
  for (const KinematicTarget& target : kinematic_targets_) {
    out.u32(target.index);
    out.vec3(target.pose.position);
    out.quat(target.pose.orientation);
  }
  for (const auto& block : blocks_) block->save(out);
  if (contact_source_ != nullptr) contact_source_->save(out);
  out.u64(hash_bytes(bytes));
  return bytes;
}

void World::restore(std::span<const std::byte> bytes) {
  const auto refuse = [](const char* rule) {
    throw std::invalid_argument(std::string("World::restore: bytes break the rule: ") + rule);
  };
  // The check value comes first: nothing is written before all bytes are known to be good.
  constexpr std::size_t kCheckBytes = 8;
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
  gravity_ = in.vec3();
  time_ = in.f64();
  const std::uint32_t slots = in.u32();
  constexpr std::size_t kBytesPerSlot = 7 + 3 * 8 + (2 * 8 + 8 + 2 + 4 + 8) + 18 * 8 + 13 * 8;
  if (in.failed() || slots > in.remaining() / kBytesPerSlot) refuse("whole");
  states_.assign(slots, {});
  props_.assign(slots, {});
  generations_.assign(slots, 0);
  alive_.assign(slots, 0);
  in_contact_.assign(slots, 0);
  activity_.assign(slots, {});
  if (!corrections_.empty()) corrections_.assign(slots, {});
  for (std::uint32_t i = 0; i < slots; ++i) {
    alive_[i] = in.u8();
    generations_[i] = in.u32();
    in_contact_[i] = in.u8();
    props_[i].type = static_cast<BodyType>(in.u8());
    props_[i].mass = in.f64();
    props_[i].inverse_mass = in.f64();
    props_[i].gravity_scale = in.f64();
    props_[i].linear_damping = in.f64();
    props_[i].angular_damping = in.f64();
    for (int k = 0; k < 3; ++k) props_[i].locks.linear[k] = in.u8() != 0;
    for (int k = 0; k < 3; ++k) props_[i].locks.angular[k] = in.u8() != 0;
    props_[i].bullet = in.u8() != 0;
    props_[i].can_sleep = in.u8() != 0;
    activity_[i].awake = in.u8() != 0;
    activity_[i].level = in.u8();
    activity_[i].calm = static_cast<std::uint16_t>(in.u32());
    activity_[i].still = in.f64();
    for (int k = 0; k < 9; ++k) props_[i].inertia_l(k / 3, k % 3) = in.f64();
    for (int k = 0; k < 9; ++k) props_[i].inverse_inertia_l(k / 3, k % 3) = in.f64();
    states_[i].pose.position = in.vec3();
    states_[i].pose.orientation = in.quat();
    states_[i].twist.linear = in.vec3();
    states_[i].twist.angular = in.vec3();
  }
  const std::uint32_t free_count = in.u32();
  if (in.failed() || free_count > slots) refuse("whole");
  free_.clear();
  free_.reserve(slots);
  for (std::uint32_t i = 0; i < free_count; ++i) free_.push_back(in.u32());
  const std::uint32_t wrench_count = in.u32();
  if (in.failed() || (wrench_count != 0 && wrench_count != slots)) refuse("whole");
  wrenches_.assign(wrench_count, {});
  for (Wrench& wrench : wrenches_) {
    wrench.force = in.vec3();
    wrench.torque = in.vec3();
  }
  const std::uint32_t kinematic_count = in.u32();
  if (in.failed() || kinematic_count > slots) refuse("whole");
  kinematic_targets_.assign(kinematic_count, {});
  for (KinematicTarget& target : kinematic_targets_) {
    target.index = in.u32();
    target.pose.position = in.vec3();
    target.pose.orientation = in.quat();
    if (target.index >= slots) refuse("whole");
  }
  for (const auto& block : blocks_) block->load(in);
  if (contact_source_ != nullptr) contact_source_->load(in);
  if (in.failed() || in.remaining() != 0) refuse("whole");
}

std::uint64_t World::hash() const {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  for (std::uint32_t i = 0; i < slot_count(); ++i) {
    if (alive_[i] == 0) continue;
    out.u32(i);
    out.vec3(states_[i].pose.position);
    out.quat(states_[i].pose.orientation);
    out.vec3(states_[i].twist.linear);
    out.vec3(states_[i].twist.angular);
  }
  return hash_bytes(bytes);
}

}  // namespace tandem::pbd
