// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world_copy.h"

#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/tether.h"

using namespace tandem::pbd;
using namespace tandem::testing;

namespace world_copy_test {
namespace {

/// A kind that says nothing of copies.
class Plain final : public ConstraintBlock {
 public:
  std::string_view name() const override { return "plain"; }
  int order() const override { return 0; }
  bool empty() const override { return true; }
  double project(const SubstepContext&) override { return 0.0; }
  BlockReport report() const override { return {.name = name()}; }
  void save(ByteWriter&) const override {}
  void load(ByteReader&) override {}
};

struct Scene {
  World world;
  Tethers& tethers = world.add_block<Tethers>();
  JointBlock& joints = world.add_block<JointBlock>();
  BodyId body = world.add_body(ball_def(1.0, 0.3, Vec3(0.0, 0.0, 1.0)));
  BodyId other = world.add_body(ball_def(1.0, 0.3, Vec3(2.0, 0.0, 1.0)));
  BodyId lift = world.add_body({.type = BodyType::Kinematic});
  ConstraintId tether = tethers.add(world, {.body = body, .anchor_w = Vec3(0.0, 0.0, 2.0)});
  JointId joint = joints.add(world, ball_joint_at(world, {}, other, Vec3(2.0, 0.0, 2.0)));
};

}  // namespace

TEST_CASE("world_copy: ids of bodies and rows hold in the copy", "[pbd][unit]") {
  Scene scene;
  const BodyId removed = scene.body;
  scene.world.remove_body(scene.body);  // generations are not all 0
  scene.body = scene.world.add_body(ball_def(2.0, 0.3, Vec3(0.0, 0.0, 1.0)));
  const ConstraintId stale = scene.tether;
  scene.tether = scene.tethers.add(scene.world, {.body = scene.body});
  REQUIRE(scene.tether.index == stale.index);
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  World& world = copy.world();
  CHECK(world.contains(scene.body));
  CHECK_FALSE(world.contains(removed));
  CHECK(world.props(scene.body).mass == 2.0);
  REQUIRE(world.blocks().size() == 2);
  auto& tethers = dynamic_cast<Tethers&>(*world.blocks()[0]);
  auto& joints = dynamic_cast<JointBlock&>(*world.blocks()[1]);
  CHECK(tethers.contains(scene.tether));
  CHECK_FALSE(tethers.contains(stale));
  CHECK(joints.contains(scene.joint));
  tethers.remove(scene.tether);
  CHECK(scene.tethers.contains(scene.tether));
  // References stay while the kinds are the same.
  REQUIRE(copy.assign(scene.world));
  CHECK(world.blocks()[0].get() == &tethers);
  CHECK(tethers.contains(scene.tether));
  scene.world.remove_block(scene.tethers);
  REQUIRE(copy.assign(scene.world));
  REQUIRE(world.blocks().size() == 1);
  CHECK(dynamic_cast<JointBlock&>(*world.blocks()[0]).contains(scene.joint));
}

TEST_CASE("world_copy: a world that cannot be copied leaves the copy empty", "[pbd][fault]") {
  Scene scene;
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  ToyContacts contacts;
  contacts.set_copies(false);
  SECTION("a block") { scene.world.add_block<Plain>(); }
  SECTION("a contact source") { scene.world.set_contact_source(&contacts); }
  CHECK_FALSE(copy.assign(scene.world));
  CHECK(copy.empty());
  CHECK(copy.world().slot_count() == 0);
  CHECK(copy.world().blocks().empty());
  CHECK(copy.world().contact_source() == nullptr);
  CHECK_THROWS_WITH(copy.restore(scene.world),
                    "WorldCopy::restore: the copy must be of a world (assign()), is empty");
  Scene another;
  REQUIRE(copy.assign(another.world));
  CHECK(copy.world().hash() == another.world.hash());
}

TEST_CASE("world_copy: a target that is built otherwise is refused and stays", "[pbd][fault]") {
  Scene scene;
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  Scene target;
  target.world.apply_force(target.body, Vec3(1.0, 2.0, 3.0));
  ToyContacts contacts;
  SECTION("a block more") { target.world.add_block<Tethers>(); }
  SECTION("a block less") { target.world.remove_block(target.tethers); }
  SECTION("a contact source") { target.world.set_contact_source(&contacts); }
  const auto before = target.world.snapshot();
  CHECK_THROWS_AS(copy.restore(target.world), std::invalid_argument);
  CHECK(target.world.snapshot() == before);
}

TEST_CASE("world_copy: a block becomes no copy of another kind", "[pbd][fault]") {
  Scene scene;
  Tethers tethers;
  JointBlock joints;
  CHECK_FALSE(tethers.assign(scene.joints));
  CHECK_FALSE(joints.assign(scene.tethers));
  CHECK(tethers.empty());
  CHECK(joints.empty());
  CHECK(tethers.assign(scene.tethers));
  CHECK(tethers.contains(scene.tether));
}

TEST_CASE("world_copy: set_state sets the given state and wakes no other body", "[pbd][unit]") {
  Scene scene;
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  World& world = copy.world();
  const BodyState state{{Vec3(1.0, 2.0, 3.0), Quat::Identity()}, {}};
  copy.set_state(scene.other.index, world.state(scene.other), false);
  copy.set_state(scene.body.index, state, false);
  CHECK_FALSE(world.awake(scene.body));
  CHECK_FALSE(world.awake(scene.other));
  CHECK(world.pose(scene.body).position == state.pose.position);
  CHECK(world.sleepers_moved() != scene.world.sleepers_moved());
  const std::uint64_t moved = world.sleepers_moved();
  copy.set_state(scene.body.index, state, false);
  CHECK(world.sleepers_moved() == moved);
  copy.set_state(scene.body.index, state, true);
  CHECK(world.awake(scene.body));
  CHECK_FALSE(world.awake(scene.other));
  copy.set_state(scene.lift.index, state, false);
  CHECK(world.awake(scene.lift));
  // A sleeping body is not solved.
  copy.set_state(scene.other.index, state, true);
  copy.set_state(scene.other.index, state, false);
  copy.set_state(scene.body.index, {{Vec3(9.0, 9.0, 9.0), Quat::Identity()}, {}}, true);
  world.remove_block(*world.blocks()[0]);
  dynamic_cast<JointBlock&>(*world.blocks()[0]).remove(scene.joint);
  std::vector<std::uint32_t> told;
  world.blocks()[0]->take_changed(told);  // or the step would wake them
  copy.set_state(scene.body.index, world.state(scene.body), true);
  Solver().step(world, kFrame);
  CHECK(world.pose(scene.other).position == state.pose.position);
  CHECK(world.twist(scene.body).linear.z() < 0.0);
}

TEST_CASE("world_copy: pending inputs are copied, read and forgotten", "[pbd][unit]") {
  Scene scene;
  CHECK(scene.world.wrenches().empty());
  CHECK(scene.world.kinematic_targets().empty());
  scene.world.apply_force(scene.body, Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 2.0));
  scene.world.apply_force(scene.body, Vec3(2.0, 0.0, 0.0));
  scene.world.set_kinematic_target(scene.lift, {Vec3(0.0, 0.0, 0.1), Quat::Identity()});
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  World& world = copy.world();
  REQUIRE(world.wrenches().size() == world.slot_count());
  CHECK(world.wrenches()[scene.body.index].force == Vec3(3.0, 0.0, 0.0));
  CHECK(world.wrenches()[scene.body.index].torque == Vec3(0.0, 1.0, 0.0));
  REQUIRE(world.kinematic_targets().size() == 1);
  CHECK(world.kinematic_targets()[0].index == scene.lift.index);
  CHECK(world.kinematic_targets()[0].pose.position.z() == 0.1);
  copy.clear_inputs();
  CHECK(world.wrenches().empty());
  CHECK(world.kinematic_targets().empty());
  CHECK(scene.world.wrenches().size() == 3);
  Scene idle;
  Solver solver;
  solver.step(world, kFrame);
  solver.step(idle.world, kFrame);
  CHECK(world.pose(scene.lift).position.z() == 0.0);
  CHECK(world.twist(scene.body).linear == idle.world.twist(idle.body).linear);
  solver.step(scene.world, kFrame);
  CHECK(scene.world.wrenches().empty());
  CHECK(scene.world.kinematic_targets().empty());
}

}  // namespace world_copy_test
