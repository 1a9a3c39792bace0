// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "body_def.h"
#include "groups.h"
#include "integrate.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/validate.h"

namespace tandem::pbd {
void World::wake_up(std::uint32_t index) {
  BodyActivity& activity = activity_[index];
  if (activity.asleep || props_[index].type != BodyType::Dynamic) note(index);
  activity.asleep = false;
  activity.stir();
}

World::World(const WorldDef& def) { set_gravity(def.gravity); }
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

std::uint32_t World::checked_index(BodyId id, const char* what) const {
  if (!contains(id)) detail::require_body(*this, id, "World", what);  // throws
  return id.index;
}

void World::reserve(std::size_t bodies) {
  states_.reserve(bodies);
  props_.reserve(bodies);
  slots_.reserve(bodies);
  in_contact_.reserve(bodies);
  activity_.reserve(bodies);
}

BodyId World::add_body(const BodyDef& def) {
  check_def(def);
  if (def.stable_id && by_stable_id_.contains(*def.stable_id)) {
    detail::refuse("BodyDef: stable_id", "that of no other body of this world",
                   std::to_string(*def.stable_id));
  }
  const std::uint32_t index = slots_.take();
  if (index == states_.size()) {
    states_.emplace_back();
    props_.resize(states_.size());
    in_contact_.push_back(0);
    activity_.resize(states_.size());
    if (!wrenches_.empty()) wrenches_.emplace_back();
    if (!corrections_.empty()) corrections_.emplace_back();
    if (!displaced_.empty()) displaced_.push_back(0);
  } else {
    activity_[index] = {};
  }
  in_contact_[index] = 0;
  if (!wrenches_.empty()) wrenches_[index] = {};
  if (!corrections_.empty()) corrections_[index] = {};
  if (!displaced_.empty()) displaced_[index] = 0;
  props_.set(index, make_props(def));
  if (def.stable_id) by_stable_id_.emplace(*def.stable_id, index);
  order_is_old_ = true;
  placements_.note();
  note(index);
  states_[index].pose = def.pose;
  states_[index].pose.orientation.normalize();
  states_[index].twist = def.type == BodyType::Static ? Twist{} : def.twist;
  const BodyId id{index, slots_.generation(index)};
  if (def.user_data != 0) set_user_data(id, def.user_data);
  return id;
}

void World::remove_body(BodyId id) {
  const std::uint32_t index = checked_index(id, "remove_body");
  wake_joined(index);
  if (contact_source_ != nullptr) contact_source_->remove_body(id);
  for (const auto& block : blocks_) block->remove_body(id);
  activity_[index] = {};
  if (!wrenches_.empty()) wrenches_[index] = {};
  kinematic_targets_.remove(index);
  if (props_[index].stable_id) by_stable_id_.erase(*props_[index].stable_id);
  order_is_old_ = true;
  placements_.note();
  note(index);
  props_.set(index, {});
  states_[index] = {};
  slots_.release(index);
}

bool World::contains(BodyId id) const { return slots_.contains(id.index, id.generation); }

BodyId World::body_at(std::uint32_t index) const {
  if (index >= states_.size() || !slots_.alive(index)) return {};
  return {index, slots_.generation(index)};
}

BodyId World::find(std::uint64_t stable_id) const {
  const auto at = by_stable_id_.find(stable_id);
  return at != by_stable_id_.end() ? body_at(at->second) : BodyId{};
}

BodyOrder World::order() const {
  if (order_is_old_) {
    order_is_old_ = false;
    ranks_.clear();
    slots_by_rank_.clear();
    if (!by_stable_id_.empty()) {
      for (const auto& [id, slot] : by_stable_id_) slots_by_rank_.push_back(slot);
      for (std::uint32_t slot = 0; slot < slot_count(); ++slot) {
        if (!props_[slot].stable_id) slots_by_rank_.push_back(slot);
      }
      ranks_.resize(slot_count());
      for (std::uint32_t rank = 0; rank < slot_count(); ++rank) {
        ranks_[slots_by_rank_[rank]] = rank;
      }
    }
  }
  return {ranks_, slots_by_rank_};
}

std::uint32_t World::slot_count() const { return static_cast<std::uint32_t>(states_.size()); }
std::size_t World::body_count() const { return slots_.count(); }

const BodyState& World::state(BodyId id) const { return states_[checked_index(id, "state")]; }
const BodyProps& World::props(BodyId id) const { return props_[checked_index(id, "props")]; }

void World::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t index = checked_index(id, "set_pose");
  check_pose(pose, "World::set_pose");
  wake(id);
  placements_.note();
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
    detail::refuse(std::string("World::") + what + ": id", "a dynamic body",
                   "body " + std::to_string(id.index));
  }
  return index;
}

void World::set_kinematic_target(BodyId id, const Pose& pose) {
  const std::uint32_t index = checked_index(id, "set_kinematic_target");
  check_pose(pose, "World::set_kinematic_target");
  detail::require(props_[index].type == BodyType::Kinematic, "World::set_kinematic_target", "id",
                  id.index, "a kinematic body");
  KinematicTarget target{index, pose};
  target.pose.orientation.normalize();
  kinematic_targets_.set(target);
  note(index);
}

void World::set_damping(BodyId id, double linear, double angular) {
  const std::uint32_t index = checked_dynamic(id, "set_damping");
  check_damping(linear, angular, "World::set_damping");
  wake(id);
  props_.own(index).linear_damping = linear;
  props_.own(index).angular_damping = angular;
}

void World::set_gravity_scale(BodyId id, double scale) {
  const std::uint32_t index = checked_dynamic(id, "set_gravity_scale");
  detail::require(std::isfinite(scale), "World::set_gravity_scale", "scale", scale, "finite");
  wake(id);
  props_.own(index).gravity_scale = scale;
}

void World::set_locks(BodyId id, const AxisLocks& locks) {
  const std::uint32_t index = checked_dynamic(id, "set_locks");
  wake(id);
  props_.own(index).locks = locks;
}

void World::set_mass(BodyId id, double mass, const Mat3& inertia) {
  const std::uint32_t index = checked_index(id, "set_mass");
  const BodyDef def{.pose = states_[index].pose, .mass = mass, .inertia = inertia};
  check_def(def);
  const BodyProps made = make_props(def);
  BodyProps props = props_[index];
  props.type = BodyType::Dynamic;
  props.mass = made.mass;
  props.inverse_mass = made.inverse_mass;
  props.inertia = made.inertia;
  props.inverse_inertia = made.inverse_inertia;
  props.principal = made.principal;
  props_.set(index, props);
  note(index);
  kinematic_targets_.remove(index);
  wake(id);
  wake_joined(index);
}

void World::set_mass(BodyId id, double mass) {
  const BodyProps& props = props_[checked_dynamic(id, "set_mass")];
  set_mass(id, mass, mass / props.mass * props.inertia);
}

void World::set_type(BodyId id, BodyType type) {
  const std::uint32_t index = checked_index(id, "set_type");
  if (type != BodyType::Static && type != BodyType::Kinematic) {
    detail::refuse("World::set_type: type", "Static or Kinematic (set_mass() makes it dynamic)",
                   static_cast<double>(type));
  }
  BodyProps props = props_[index];
  props.type = type;
  props.mass = 0.0;
  props.inverse_mass = 0.0;
  props.inertia.setZero();
  props.inverse_inertia.setZero();
  props.principal = {};
  props_.set(index, props);
  note(index);
  if (!wrenches_.empty()) wrenches_[index] = {};
  kinematic_targets_.remove(index);
  if (type == BodyType::Static) states_[index].twist = {};
  wake(id);
}

std::uint64_t World::user_data(BodyId id) const {
  const std::uint32_t index = checked_index(id, "user_data");
  const bool known = index < user_data_.size() && user_data_[index].generation == id.generation;
  return known ? user_data_[index].value : 0;
}

void World::set_user_data(BodyId id, std::uint64_t value) {
  const std::uint32_t index = checked_index(id, "set_user_data");
  if (index >= user_data_.size()) user_data_.resize(states_.size());
  user_data_[index] = {id.generation, value};
}

void World::add_wrench(std::uint32_t index, const Wrench& wrench, const char* what) {
  Wrench sum = wrenches_.empty() ? Wrench{} : wrenches_[index];
  sum.force += wrench.force;
  sum.torque += wrench.torque;
  detail::require_finite(sum.force, what, "sum of forces");
  detail::require_finite(sum.torque, what, "sum of torques");
  wake({index, slots_.generation(index)});
  if (wrenches_.empty()) wrenches_.resize(states_.size());
  wrenches_[index] = sum;
}

void World::apply_force(BodyId id, const Vec3& force) {
  const std::uint32_t index = checked_dynamic(id, "apply_force");
  detail::require_finite(force, "World::apply_force", "force");
  add_wrench(index, {force, Vec3::Zero()}, "World::apply_force");
}

void World::apply_force(BodyId id, const Vec3& force, const Vec3& point_w) {
  const std::uint32_t index = checked_dynamic(id, "apply_force");
  detail::require_finite(force, "World::apply_force", "force");
  detail::require_finite(point_w, "World::apply_force", "point_w");
  add_wrench(index, {force, (point_w - states_[index].pose.position).cross(force)},
             "World::apply_force");
}

void World::apply_torque(BodyId id, const Vec3& torque) {
  const std::uint32_t index = checked_dynamic(id, "apply_torque");
  detail::require_finite(torque, "World::apply_torque", "torque");
  add_wrench(index, {Vec3::Zero(), torque}, "World::apply_torque");
}

void World::apply_impulse(BodyId id, const Vec3& impulse) {
  const std::uint32_t index = checked_dynamic(id, "apply_impulse");
  detail::require_finite(impulse, "World::apply_impulse", "impulse");
  add_impulse(index, {impulse, Vec3::Zero()}, "World::apply_impulse");
}

void World::apply_impulse(BodyId id, const Vec3& impulse, const Vec3& point_w) {
  const std::uint32_t index = checked_dynamic(id, "apply_impulse");
  detail::require_finite(impulse, "World::apply_impulse", "impulse");
  detail::require_finite(point_w, "World::apply_impulse", "point_w");
  const Vec3 moment = (point_w - states_[index].pose.position).cross(impulse);
  add_impulse(index, {impulse, moment}, "World::apply_impulse");
}

void World::apply_angular_impulse(BodyId id, const Vec3& impulse) {
  const std::uint32_t index = checked_dynamic(id, "apply_angular_impulse");
  detail::require_finite(impulse, "World::apply_angular_impulse", "impulse");
  add_impulse(index, {Vec3::Zero(), impulse}, "World::apply_angular_impulse");
}

void World::add_impulse(std::uint32_t index, const Wrench& impulse, const char* what) {
  const BodyProps& props = props_[index];
  detail::require_finite(impulse.torque, what, "moment");
  Twist twist = states_[index].twist;
  Vec3 change = props.inverse_mass * impulse.force;
  zero_locked_axes(props.locks.linear, change);
  twist.linear += change;
  Mat3 inverse_inertia;
  inverse_inertia_w(states_[index].pose.orientation, props, inverse_inertia);
  twist.angular += inverse_inertia * impulse.torque;
  check_twist(twist, what);
  wake({index, slots_.generation(index)});
  states_[index].twist = twist;
}

bool World::awake(BodyId id) const { return awake_at(checked_index(id, "awake")); }

void World::resume(BodyId id, const BodyState& state, const BodyActivity& activity) {
  const std::uint32_t index = checked_index(id, "resume");
  check_pose(state.pose, "World::resume");
  check_twist(state.twist, "World::resume");
  detail::require(activity.level <= Groups::kMaxLevel, "World::resume", "activity.level",
                  activity.level, "a level of refinement");
  detail::require(activity.low_speed_time >= 0.0, "World::resume", "activity.low_speed_time",
                  activity.low_speed_time, ">= 0 s");
  detail::require_finite(activity.moved, "World::resume", "activity.moved");
  detail::require_finite(activity.turned, "World::resume", "activity.turned");
  if (activity.asleep) ++sleepers_moved_;
  const Pose& before = states_[index].pose;
  if (before.position != state.pose.position ||
      before.orientation.coeffs() != state.pose.orientation.coeffs()) {
    placements_.note();
  }
  if (activity.asleep || activity_[index].asleep || props_[index].type != BodyType::Dynamic) {
    note(index);
  }
  states_[index] = state;
  activity_[index] = activity;
}

void World::wake(BodyId id) {
  const std::uint32_t index = checked_index(id, "wake");
  wake_up(index);
  if (props_[index].type != BodyType::Dynamic) wake_joined(index);
}

void World::wake_joined(std::uint32_t index) {
  joined_.clear();
  for (const auto& block : blocks_) block->append_joined(index, joined_);
  for (const std::uint32_t body : joined_) wake_up(body);
}

void World::set_gravity(const Vec3& gravity) {
  detail::require_finite(gravity, "World", "gravity");
  gravity_ = gravity;
  for (std::uint32_t i = 0; i < slot_count(); ++i) {
    if (props_[i].type == BodyType::Static && !activity_[i].asleep) continue;
    activity_[i].asleep = false;
    activity_[i].stir();
  }
  body_log_.outdate();
}

void World::insert_block(std::unique_ptr<ConstraintBlock> block) {
  // Blocks of equal order stay in the order of adding.
  const auto after = std::upper_bound(blocks_.begin(), blocks_.end(), block->order(),
                                      [](int order, const std::unique_ptr<ConstraintBlock>& other) {
                                        return order < other->order();
                                      });
  blocks_.insert(after, std::move(block));
}

void World::remove_block(const ConstraintBlock& block) {
  const auto at = std::find_if(
      blocks_.begin(), blocks_.end(),
      [&](const std::unique_ptr<ConstraintBlock>& own) { return own.get() == &block; });
  // The block may have been destroyed: it is not read.
  if (at == blocks_.end()) {
    detail::refuse("World::remove_block: block", "one of the world's blocks()", "unknown");
  }
  if (&block == contacts_) {
    detail::refuse("World::remove_block: block", "one that add_block() made", "that of contacts");
  }
  std::vector<ConstraintEdge> edges;
  block.append_edges(edges);
  std::vector<std::uint32_t> named;
  for (const ConstraintEdge& edge : edges) named.insert(named.end(), {edge.body_a, edge.body_b});
  // Bodies of rows removed since the last step are known only here.
  (*at)->take_changed(named);
  blocks_.erase(at);
  for (const std::uint32_t body : named) {
    // The world is kNone, and a snapshot's list of changes may hold any number.
    if (body < activity_.size()) wake_up(body);
  }
}

void World::set_contact_source(ContactSource* source) {
  if (source != nullptr && contacts_ == nullptr) contacts_ = &add_block<ContactBlock>();
  contact_source_ = source;
  body_log_.outdate();
}

Correction World::correction(BodyId id) const {
  const std::uint32_t index = checked_index(id, "correction");
  return corrections_.empty() ? Correction{} : corrections_[index];
}

bool World::in_contact(BodyId id) const {
  return in_contact_[checked_index(id, "in_contact")] != 0;
}

}  // namespace tandem::pbd
