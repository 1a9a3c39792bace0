// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>

#include "fixture.h"
#include "support/targets.h"
#include "tandem/collision/contact_events.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace restore_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using namespace tandem::pbd;

namespace {

/// All that a snapshot has to bring back: bodies that sleep and bodies that move, a heavy box on
/// light ones whose island is refined, joints of several kinds that carry loads, one of them
/// broken, a kinematic body under way to a target, a force for the next step, targets, materials,
/// rows just added.
struct Scene {
  World world;
  CollisionScene shapes;
  ContactEvents events;
  tandem::testing::FixedTargets targets;
  DistanceJoints& rods = world.add_block<DistanceJoints>();
  JointBlock& joints = world.add_block<JointBlock>();
  std::vector<BodyId> ids;
  std::vector<ConstraintId> rod_ids;
  std::vector<JointId> ball_ids, joint_ids;
  BodyId lift, sleeper;
  Solver solver;
  StepReport report;

  Scene() {
    world.set_contact_source(&shapes);
    world.set_target_source(&targets);
    add(HalfSpace{}, at(0, 0, 0), BodyType::Static);
    Random random(12);
    for (int i = 0; i < 14; ++i) {  // falls on and on while the rest sleeps
      const Shape shape = i % 2 == 0 ? Shape(Sphere{0.2}) : Shape(Box{Vec3(0.2, 0.15, 0.25)});
      add(shape, {Vec3(random.in(-0.5, 0.5), random.in(-0.5, 0.5), 0.5 + 0.7 * i), random.quat()});
    }
    for (int i = 0; i < 4; ++i) add(Box{Vec3::Constant(0.25)}, at(5.0, 0, 0.25 + 0.5 * i));
    add(Box{Vec3::Constant(0.25)}, at(5.0, 0, 2.25), BodyType::Dynamic, 200.0);
    sleeper = add(Box{Vec3::Constant(0.3)}, at(-5.0, 0, 0.3));
    add(Box{Vec3::Constant(0.3)}, at(-5.0, 0, 0.9));
    lift = add(Box{Vec3(0.5, 0.5, 0.1)}, at(0, 5.0, 0.5), BodyType::Kinematic);
    add(Sphere{0.2}, at(0, 5.0, 0.8));
    std::vector<BodyId> links;
    for (int i = 0; i < 9; ++i) links.push_back(add(Sphere{0.1}, at(8.0 + 0.3 * i, 3.0, 4.0)));
    for (std::size_t i = 0; i + 1 < 3; ++i) {
      ball_ids.push_back(joints.add(
          world, ball_joint_at(world, links[i], links[i + 1], world.pose(links[i]).position)));
    }
    rod_ids.push_back(
        rods.add(world, {.a = links[2], .b = links[3], .rest_length = 0.3, .compliance = 1e-4}));
    for (std::size_t i = 3; i + 1 < links.size(); ++i) {
      SixDofJointDef def;
      def.a = links[i];
      def.b = links[i + 1];
      def.frame_b.anchor = Vec3(-0.3, 0.0, 0.0);
      for (JointAxis& axis : def.linear) axis.freedom = Freedom::Locked;
      if (i + 2 == links.size()) def.break_force = 1e-3;  // at once
      joint_ids.push_back(joints.add(world, def));
    }
    ball_ids.push_back(
        joints.add(world, ball_joint_at(world, BodyId{}, links[0], Vec3(7.8, 3.0, 4.0))));
    targets.targets.push_back({.body = ids[3],
                               .pose = at(0.3, 0.2, 0.4),
                               .share = 0.05,
                               .motion = TargetMotion::WithBody});
  }

  BodyId add(const Shape& shape, const Pose& pose, BodyType type = BodyType::Dynamic,
             double weight = 1.0) {
    BodyDef def;
    def.can_sleep = weight == 1.0;
    def.type = type;
    def.pose = pose;
    if (type == BodyType::Dynamic) {
      const auto properties = mass_properties(shape, 500.0);
      def.mass = weight * properties.mass;
      def.inertia = weight * properties.inertia;
    }
    ids.push_back(world.add_body(def));
    const double restitution = ids.size() % 3 == 0 ? 0.5 : 0.0;
    shapes.add(world, {.body = ids.back(),
                       .shape = shape,
                       .local = {},
                       .material = {.friction = 0.6, .restitution = restitution},
                       .filter = {}});
    return ids.back();
  }
  void step() {
    report = solver.step(world, kDt);
    events.update(world, shapes);
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) step();
  }

  /// Input of the next step besides the state: everything that can be pending.
  void leave_pending() {
    world.set_kinematic_target(lift, at(0.0, 5.0, 0.55));
    world.apply_force(ids[2], Vec3(3.0, 1.0, 20.0), world.pose(ids[2]).position + Vec3(0, 0.1, 0));
    // The box that sleeps is tied to something: it wakes in the next step.
    rod_ids.push_back(rods.add(
        world,
        {.a = BodyId{}, .b = sleeper, .anchor_a_l = Vec3(-5.0, 0.0, 2.0), .rest_length = 1.6}));
  }
};

/// Every public reading of the world, as bytes; what went into them is counted.
std::vector<std::byte> readings(const Scene& s) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  for (const BodyId id : s.ids) {
    const BodyState& state = s.world.state(id);
    const Correction correction = s.world.correction(id);
    out.quat(state.pose.orientation);
    for (const Vec3& v :
         {state.pose.position, state.twist.linear, state.twist.angular, correction.translation,
          correction.rotation, correction.twist.linear, correction.twist.angular}) {
      out.vec3(v);
    }
    out.u8(s.world.awake(id) ? 1 : 0);
    out.u8(s.world.in_contact(id) ? 1 : 0);
  }
  for (const Contact& c : s.world.contacts()->contacts()) {
    const Manifold& m = c.manifold;
    out.u64(m.key);
    out.u64(m.order);
    out.u32(m.body_a);
    out.u32(m.body_b);
    for (const Vec3& v : {m.normal, c.friction_force}) out.vec3(v);
    for (const double v : {m.radius_a, m.radius_b, m.friction, m.restitution, c.approach_speed,
                           c.impulse, c.warm_start_scale, c.overlap}) {
      out.f64(v);
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
      out.vec3(m.points[i].anchor_a_l);
      out.vec3(m.points[i].anchor_b_l);
      out.u32(m.points[i].feature);
      out.f64(c.force[i]);
    }
  }
  out.u8(s.world.contacts()->any_friction() ? 1 : 0);
  out.u8(s.world.contacts()->any_restitution() ? 1 : 0);
  for (const ConstraintId id : s.rod_ids) {
    const DistanceJoint& joint = s.rods.at(id);
    out.f64(joint.force());
    out.f64(joint.residual());
    out.f64(joint.displacement_residual());
  }
  for (const auto& ids : {s.ball_ids, s.joint_ids}) {
    for (const JointId id : ids) {
      const JointState& state = s.joints.at(id);
      out.vec3(state.force);
      out.vec3(state.torque);
      for (const double v : state.position) out.f64(v);
      for (const double v : state.load) out.f64(v);
      out.f64(state.swing);
      out.f64(state.residual);
      out.u8(state.broken ? 1 : 0);
    }
  }
  for (const auto& block : s.world.blocks()) {
    const BlockReport report = block->report();
    out.u32(static_cast<std::uint32_t>(report.rows));
    out.u32(static_cast<std::uint32_t>(report.extra_rows));
    out.f64(report.residual);
    out.f64(report.displacement_residual);
  }
  out.f64(s.world.time());
  out.vec3(s.world.gravity());
  return bytes;
}

/// Report of the last step and the events after it.
std::vector<std::byte> announcements(const Scene& s) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  const StepReport& r = s.report;
  for (const int value : {r.substeps, r.bodies, r.targets, r.awake, r.stopped, r.groups,
                          r.velocity_iterations, r.turning}) {
    out.u32(static_cast<std::uint32_t>(value));
  }
  for (const double value :
       {r.energy.displacement, r.energy.velocity_agreement, r.energy.potential}) {
    out.f64(value);
  }
  for (const bool ran : r.ran) out.u8(ran ? 1 : 0);
  for (const BlockReport& block : r.blocks) {
    out.u32(static_cast<std::uint32_t>(block.rows));
    out.u32(static_cast<std::uint32_t>(block.extra_rows));
    out.f64(block.residual);
    out.f64(block.displacement_residual);
  }
  for (const auto& list : {s.events.begun(), s.events.ended(), s.events.touching()}) {
    out.u32(static_cast<std::uint32_t>(list.size()));
    for (const ContactPair& pair : list) {
      out.u32(pair.a.index);
      out.u32(pair.b.index);
    }
  }
  for (const ContactHit& hit : s.events.hits()) {
    out.f64(hit.speed);
    out.f64(hit.impulse);
    out.vec3(hit.point);
    out.vec3(hit.normal);
  }
  return bytes;
}

/// Keeps the bytes out of the message.
bool same(const std::vector<std::byte>& l, const std::vector<std::byte>& r) { return l == r; }

}  // namespace

TEST_CASE("restore: all that can be read of a world is as it was, and so is all that follows",
          "[collision][golden]") {
  Scene straight;
  straight.steps(75);
  straight.leave_pending();
  // The claims of the scene hold, so that something is at stake.
  REQUIRE_FALSE(straight.world.awake(straight.sleeper));
  REQUIRE(straight.world.awake(straight.ids[2]));
  REQUIRE(straight.report.groups > 1);
  REQUIRE(straight.joints.at(straight.joint_ids.back()).broken);
  REQUIRE(straight.joints.at(straight.ball_ids.back()).force.norm() > 1.0);
  REQUIRE(straight.world.correction(straight.ids[3]).translation.norm() > 0.0);
  const auto& contacts = straight.world.contacts()->contacts();
  REQUIRE(std::any_of(contacts.begin(), contacts.end(),
                      [](const Contact& c) { return c.friction_force.norm() > 0.1; }));
  const auto bytes = straight.world.snapshot();
  std::vector<std::byte> event_bytes;
  ByteWriter event_writer(event_bytes);
  straight.events.save(event_writer);
  const auto before = readings(straight);

  Scene later;  // has run on, otherwise
  later.steps(75);
  later.leave_pending();
  later.steps(9);
  Scene fresh;  // has never run
  for (Scene* other : {&later, &fresh}) {
    other->rod_ids = straight.rod_ids;
    other->world.restore(bytes);
    ByteReader event_reader(event_bytes);
    other->events.load(event_reader);
    CHECK(same(readings(*other), before));
    CHECK(same(other->world.snapshot(), bytes));
  }
  bool woke = false;
  for (int i = 0; i < 60; ++i) {
    straight.step();
    woke = woke || straight.world.awake(straight.sleeper);
    for (Scene* other : {&later, &fresh}) {
      other->step();
      INFO("step " << i << (other == &fresh ? " of the fresh one" : " of the one that had run on"));
      REQUIRE(same(readings(*other), readings(straight)));
      REQUIRE(same(announcements(*other), announcements(straight)));
    }
  }
  CHECK(woke);
}

}  // namespace restore_test
