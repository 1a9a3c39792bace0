// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes.h"

#include <numbers>

#include "tandem/pbd/joint.h"
#include "tandem/pbd/tether.h"

namespace tandem::stability_bench {
namespace {

using pbd::Vec3;

constexpr double kEdge = 0.1;  // m
constexpr double kMass = 0.3;  // kg

class Builder {
 public:
  Builder() {
    copy_.world = std::make_unique<pbd::World>();
    copy_.contacts = std::make_unique<collision::CollisionScene>();
  }

  pbd::BodyId cube(const Vec3& position, bool collides) {
    const collision::Box box{Vec3::Constant(0.5 * kEdge)};
    const auto properties = collision::mass_properties(box, kMass / (kEdge * kEdge * kEdge));
    pbd::BodyDef def;
    def.pose.position = position;
    def.mass = properties.mass;
    def.inertia = properties.inertia_l;
    def.can_sleep = false;  // what sleeps says nothing of stability
    const pbd::BodyId body = copy_.world->add_body(def);
    copy_.bodies.push_back(body);
    if (collides) copy_.contacts->add(*copy_.world, {.body = body, .shape = box});
    return body;
  }
  void wall(const Vec3& centre, const Vec3& half) {
    pbd::BodyDef def;
    def.type = pbd::BodyType::Static;
    def.pose.position = centre;
    const pbd::BodyId body = copy_.world->add_body(def);
    copy_.contacts->add(*copy_.world, {.body = body, .shape = collision::Box{half}});
  }
  pbd::BodyId hook() { return copy_.world->add_body({.type = pbd::BodyType::Static}); }
  pbd::World& world() { return *copy_.world; }
  Copy done(bool touching) {
    if (touching) copy_.world->set_contact_source(copy_.contacts.get());
    return std::move(copy_);
  }

 private:
  Copy copy_;
};

Copy free_body(double apart) {
  Builder b;
  b.world().set_gravity(Vec3::Zero());
  b.cube(Vec3(apart, 0.0, 0.0), false);
  return b.done(false);
}

/// 3 Hz, a tenth of critical damping.
Copy spring(double apart) {
  Builder b;
  b.world().set_gravity(Vec3::Zero());
  const pbd::BodyId body = b.cube(Vec3(apart, 0.0, 0.0), false);
  const double w = 2.0 * std::numbers::pi * 3.0;
  auto& tethers = b.world().add_block<pbd::Tethers>();
  tethers.add(b.world(), {.body = body, .stiffness = kMass * w * w, .damping = 0.2 * kMass * w});
  return b.done(false);
}

/// Five cubes on the ground.
Copy stack(double apart) {
  Builder b;
  b.wall(Vec3(0.0, 0.0, -0.5), Vec3(5.0, 5.0, 0.5));
  for (int i = 0; i < 5; ++i) b.cube(Vec3(apart, 0.0, kEdge * (i + 0.5)), true);
  return b.done(true);
}

/// Ten cubes side by side on the ground; where one copy is shifted, a wall is in the way.
Copy row(double apart) {
  Builder b;
  b.wall(Vec3(0.0, 0.0, -0.5), Vec3(5.0, 5.0, 0.5));
  b.wall(Vec3(10.5 * kEdge + 0.51, 0.0, 0.5), Vec3(0.5, 1.0, 0.5));
  for (int i = 0; i < 10; ++i) b.cube(Vec3(kEdge * i + apart, 0.0, 0.5 * kEdge), true);
  return b.done(true);
}

/// Ten links that hang from a hook, turned aside as a whole in one copy.
Copy chain(double apart) {
  Builder b;
  const pbd::BodyId hook = b.hook();
  const double angle = apart / kEdge * 0.1;
  const Vec3 down(std::sin(angle), 0.0, -std::cos(angle));
  auto& joints = b.world().add_block<pbd::JointBlock>();
  pbd::BodyId above = hook;
  for (int i = 0; i < 10; ++i) {
    const pbd::BodyId link = b.cube((i + 0.5) * kEdge * down, false);
    joints.add(b.world(), pbd::ball_joint_at(b.world(), above, link, i * kEdge * down));
    above = link;
  }
  return b.done(false);
}

}  // namespace

Copy build(Kind kind, double apart) {
  switch (kind) {
    case Kind::Free:
      return free_body(apart);
    case Kind::Spring:
      return spring(apart);
    case Kind::Stack:
      return stack(apart);
    case Kind::Row:
      return row(apart);
    case Kind::Chain:
      break;
  }
  return chain(apart);
}

}  // namespace tandem::stability_bench
