// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gltf_joints.h"

#include <utility>

#include "reader.h"

namespace tandem::scene_files {
namespace {

/// Reads a limit: all axes locked, one limited, or two angular ones in a cone.
void read_limit(const Place& at, pbd::SixDofJointDef& def) {
  Reader io(at);
  const bool angular = io.has("angularAxes");
  if (io.has("linearAxes") == angular) at.refuse("of linearAxes or of angularAxes");
  double low = -pbd::kUnlimited;
  double high = pbd::kUnlimited;
  double stiffness = pbd::kUnlimited;
  double damping = 0.0;
  io("min", low);
  io("max", high);
  io("stiffness", stiffness);
  io("damping", damping);
  io.finish();
  const Place axes = at.at(angular ? "angularAxes" : "linearAxes");
  const double compliance = stiffness > 0.0 ? 1.0 / stiffness : pbd::kUnlimited;
  if (angular && axes.size() == 2 && high > 0.0) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (axes.at(k).integer(0, 2) == 0) axes.refuse("[1, 2]: cones are about x");
    }
    def.cone = high;
    def.cone_compliance = compliance;
    def.cone_damping = damping;
    return;
  }
  if (axes.size() > 1 && high > 0.0) at.warn("each axis is limited by itself");
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const auto which = static_cast<std::size_t>(axes.at(k).integer(0, 2));
    pbd::JointAxis& axis = angular ? def.angular[which] : def.linear[which];
    const bool locked = high == 0.0 && (low == 0.0 || axes.size() > 1);
    axis.freedom = locked ? pbd::Freedom::Locked : pbd::Freedom::Limited;
    axis.lower = low;
    axis.upper = high;
    axis.compliance = compliance;
    axis.damping = damping;
  }
}

void read_drive(const Place& at, pbd::SixDofJointDef& def) {
  Reader io(at);
  std::string type;
  std::string mode = "force";
  double speed = 0.0;
  std::uint32_t which = 0;
  pbd::JointSpring spring;
  double most = pbd::kUnlimited;
  io("type", type);
  io("mode", mode);
  io("axis", which);
  io("maxForce", most);
  io("positionTarget", spring.rest);
  io("velocityTarget", speed);
  io("stiffness", spring.stiffness);
  io("damping", spring.damping);
  io.finish();
  if (type != "linear" && type != "angular") at.refuse("of type linear or angular");
  if (which > 2) at.at("axis").refuse("0, 1 or 2");
  if (mode != "force") at.at("mode").warn("read as force");
  pbd::JointAxis& axis = type == "linear" ? def.linear[which] : def.angular[which];
  if (axis.freedom == pbd::Freedom::Locked) return at.warn("its axis is locked");
  if (speed != 0.0 && spring.stiffness == 0.0 && spring.damping > 0.0) {
    axis.motor = {.mode = pbd::MotorMode::Velocity,
                  .target = speed,
                  .max_force = most,
                  .damping = spring.damping};
    return;
  }
  if (speed != 0.0) {
    axis.motor = {.mode = pbd::MotorMode::Velocity, .target = speed, .max_force = most};
    if (spring.stiffness != 0.0 || most == pbd::kUnlimited) at.warn("held at velocityTarget alone");
    return;
  }
  if (most == pbd::kUnlimited) {
    axis.spring = spring;
    return;
  }
  // Without stiffness it is a damper; with neither it does nothing.
  const bool pulls = spring.stiffness > 0.0;
  if (!pulls && spring.damping == 0.0) return;
  axis.motor = {.mode = pulls ? pbd::MotorMode::Position : pbd::MotorMode::Velocity,
                .target = pulls ? spring.rest : 0.0,
                .max_force = most,
                .stiffness = spring.stiffness,
                .damping = spring.damping};
}

/// The same joint seen from the other body.
void turn_over(pbd::SixDofJointDef& def) {
  for (auto* axes : {&def.linear, &def.angular}) {
    for (pbd::JointAxis& axis : *axes) {
      axis.lower = -std::exchange(axis.upper, -axis.lower);
      axis.spring.rest = -axis.spring.rest;
      axis.motor.target = -axis.motor.target;
    }
  }
}

}  // namespace

std::vector<std::int32_t> GltfJoints::groups(std::size_t bodies) {
  std::vector<std::int32_t> group(bodies, 0);
  for (const Joined& one : joined_) {
    if (one.meet || !one.a || !one.b) continue;
    const std::int32_t first = group[*one.a];
    const std::int32_t second = group[*one.b];
    const std::int32_t both = first != 0 ? first : second != 0 ? second : out_.scene.new_group();
    group[*one.a] = group[*one.b] = both;
    if (first == 0 || second == 0 || first == second) continue;
    for (std::int32_t& other : group) other = other == second ? both : other;
  }
  return group;
}

pbd::SixDofJointDef GltfJoints::describe(std::size_t description) {
  const auto [known, fresh] = known_.try_emplace(description);
  pbd::SixDofJointDef& def = known->second;
  if (!fresh) return def;
  const Place extensions = document_.at("extensions");
  const Place physics = extensions.at("KHR_physics_rigid_bodies");
  const Place list = physics.at("physicsJoints");
  const Place joint = list.at(description);
  if (joint.has("limits")) {
    const Place limits = joint.at("limits");
    for (std::size_t i = 0; i < limits.size(); ++i) read_limit(limits.at(i), def);
  }
  if (joint.has("drives")) {
    const Place drives = joint.at("drives");
    for (std::size_t i = 0; i < drives.size(); ++i) read_drive(drives.at(i), def);
  }
  return def;
}

void GltfJoints::build() {
  const pbd::World& world = out_.scene.world();
  for (Joined& one : joined_) {
    pbd::SixDofJointDef def = describe(one.description);
    if (!one.b) {
      std::swap(one.a, one.b);
      std::swap(one.frame_a, one.frame_b);
      turn_over(def);
    }
    const auto frame = [&](BodyId body, const Pose& at) -> pbd::JointFrame {
      if (!body.valid()) return {at.position, at.orientation};
      const Pose& pose = world.pose(body);
      return {pose.to_local(at.position),
              (pose.orientation.conjugate() * at.orientation).normalized()};
    };
    if (one.a) def.a = out_.bodies[*one.a].body;
    def.b = out_.bodies[*one.b].body;
    def.frame_a = frame(def.a, one.frame_a);
    def.frame_b = frame(def.b, one.frame_b);
    document_.guard([&] { out_.joints.push_back({one.name, out_.scene.add_joint(def)}); });
  }
}

}  // namespace tandem::scene_files
