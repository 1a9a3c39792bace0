// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world_copy.h"

#include <optional>

#include "allocation_count.h"
#include "fixture.h"
#include "scenes.h"
#include "support/targets.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/tether.h"

namespace world_copy_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using namespace tandem::pbd;

namespace {

/// All that a copy has to take over: stacks, a heap on a mesh, bodies that sleep, a lift that
/// moves, a chain, rods, tethers under way.
struct Scene {
  World world;
  CollisionScene shapes;
  Tethers& tethers = world.add_block<Tethers>();
  DistanceJoints& rods = world.add_block<DistanceJoints>();
  JointBlock& joints = world.add_block<JointBlock>();
  BodyId lift, sleeper, top, heap;
  ConstraintId tether, rod;
  JointId joint;
  bool named;  ///< bodies have stable ids, which are not in the order of slots
  std::uint64_t next_name = 1000;

  explicit Scene(bool with_names = false) : named(with_names) {
    world.set_contact_source(&shapes);
    add(HalfSpace{}, at(0, 0, -1.0), BodyType::Static);
    add(flat_mesh(8.0, 8), at(0, 0, 0), BodyType::Static);
    Random random(12);
    const std::vector<Shape> kinds = convex_shapes(0.5);
    for (int i = 0; i < 18; ++i) {
      heap = add(kinds[static_cast<std::size_t>(i) % kinds.size()],
                 {Vec3(random.in(-0.6, 0.6), random.in(-0.6, 0.6), 0.5 + 0.4 * i), random.quat()});
    }
    for (int i = 0; i < 5; ++i) top = add(Box{Vec3::Constant(0.25)}, at(12, 0, -0.75 + 0.5 * i));
    sleeper = add(Box{Vec3::Constant(0.3)}, at(-12, 0, -0.7));
    add(Box{Vec3::Constant(0.3)}, at(-12, 0, -0.1));
    lift = add(Box{Vec3(0.5, 0.5, 0.1)}, at(0, 12, 0.5), BodyType::Kinematic);
    add(Sphere{0.2}, at(0, 12, 0.8));
    BodyId before;
    for (int i = 0; i < 6; ++i) {
      const BodyId link = add(Sphere{0.1}, at(8.0 + 0.3 * i, 9.0, 4.0));
      joint = joints.add(world, ball_joint_at(world, before, link, Vec3(7.85 + 0.3 * i, 9.0, 4.0)));
      before = link;
    }
    const BodyId hung = add(Sphere{0.1}, at(10.0, 9.0, 4.0));
    rod = rods.add(world, {.a = before, .b = hung, .rest_length = 0.5, .compliance = 1e-4});
    tether = tethers.add(world, {.body = top,
                                 .anchor_w = Vec3(12, 0, 1.5),
                                 .anchor_velocity = Vec3(0.1, 0, 0),
                                 .stiffness = 50.0});
  }

  BodyId add(const Shape& shape, const Pose& pose, BodyType type = BodyType::Dynamic) {
    BodyDef def;
    def.type = type;
    def.pose = pose;
    if (named) def.stable_id = next_name--;
    if (type == BodyType::Dynamic) {
      const auto properties = mass_properties(shape, 500.0);
      def.mass = properties.mass;
      def.inertia = properties.inertia;
    }
    const BodyId id = world.add_body(def);
    ColliderDef collider;
    collider.body = id;
    collider.shape = shape;
    collider.material.friction = 0.6;
    shapes.add(world, collider);
    return id;
  }
};

/// A caller's changes to a world from step to step.
void step(World& world, Solver& solver, const Scene& names, int i) {
  const double height = 0.5 + 0.3 * std::sin(0.05 * i);
  world.set_kinematic_target(names.lift, at(0, 12, height));
  if (i % 20 == 3) world.apply_force(names.heap, Vec3(40.0, 0.0, 90.0));
  solver.step(world, kDt);
}

void steps(World& world, Solver& solver, const Scene& names, int from, int to) {
  for (int i = from; i < to; ++i) step(world, solver, names, i);
}

/// Every bit that the next step depends on. Keeps the bytes out of the message.
bool same(const World& l, const World& r) { return l.snapshot() == r.snapshot(); }

}  // namespace

TEST_CASE("world_copy: a copy moves as the original does, bit for bit", "[collision][golden]") {
  const bool named = GENERATE(false, true);
  Scene scene(named);
  Solver solver;
  steps(scene.world, solver, scene, 0, 60);
  scene.world.apply_force(scene.top, Vec3(1.0, 0.0, 0.0));  // pending
  REQUIRE_FALSE(scene.world.awake(scene.sleeper));
  REQUIRE(scene.world.contacts()->contacts().size() > 20);
  WorldCopy copy;
  REQUIRE(copy.empty());
  REQUIRE(copy.assign(scene.world));
  REQUIRE_FALSE(copy.empty());
  World& world = copy.world();
  CHECK(same(world, scene.world));
  CHECK(world.wrenches().size() == world.slot_count());
  REQUIRE(world.blocks().size() == scene.world.blocks().size());
  for (std::size_t i = 0; i < world.blocks().size(); ++i) {
    CHECK(world.blocks()[i]->name() == scene.world.blocks()[i]->name());
  }
  CHECK(world.contact_source() != scene.world.contact_source());
  const auto& shapes = dynamic_cast<const CollisionScene&>(*world.contact_source());
  CHECK(std::get<Mesh>(shapes.collider({1, 0}).shape) ==
        std::get<Mesh>(scene.shapes.collider({1, 0}).shape));
  Solver own;
  for (int i = 60; i < 180; ++i) {
    step(scene.world, solver, scene, i);
    step(world, own, scene, i);
    INFO("step " << i);
    REQUIRE(same(world, scene.world));
  }
}

TEST_CASE("world_copy: an object that was used before becomes the same copy as a new one",
          "[collision][regression]") {
  Scene scene;
  Scene other(true);
  Solver solver;
  Solver own;
  steps(other.world, solver, other, 0, 50);
  WorldCopy copy;
  REQUIRE(copy.assign(other.world));
  steps(copy.world(), own, other, 50, 60);
  for (int i = 0; i < 90; ++i) {
    // The past is replayed in each step, and then runs on into a future that never comes.
    REQUIRE(copy.assign(scene.world));
    REQUIRE(same(copy.world(), scene.world));
    step(scene.world, solver, scene, i);
    step(copy.world(), own, scene, i);
    INFO("step " << i);
    REQUIRE(same(copy.world(), scene.world));
    steps(copy.world(), own, scene, i + 1, i + 1 + i % 4);
  }
}

TEST_CASE("world_copy: a world that is rolled back goes on as it did before",
          "[collision][golden]") {
  Scene scene;
  Solver solver;
  steps(scene.world, solver, scene, 0, 60);
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  const auto then = scene.world.snapshot();
  const auto future = [&] {
    steps(scene.world, solver, scene, 60, 90);
    return scene.world.snapshot();
  };
  const auto first = future();

  SECTION("nothing was added or removed") {}
  SECTION("bodies, colliders and rows were removed") {
    scene.world.remove_body(scene.top);
    scene.world.remove_body(scene.sleeper);
    scene.joints.remove(scene.joint);
    scene.shapes.remove({3, 0});
  }
  SECTION("bodies, colliders and rows were added") {
    const BodyId more = scene.add(Box{Vec3::Constant(0.2)}, at(0.1, 0.1, 3.0));
    scene.rods.add(scene.world, {.a = more, .b = scene.heap, .rest_length = 1.0});
    scene.tethers.add(scene.world, {.body = more});
    scene.joints.add(scene.world, ball_joint_at(scene.world, {}, scene.lift, Vec3(0, 12, 1)));
  }
  steps(scene.world, solver, scene, 90, 100);
  copy.restore(scene.world);
  REQUIRE(scene.world.snapshot() == then);
  CHECK(scene.world.contains(scene.top));
  CHECK(scene.joints.contains(scene.joint));
  CHECK(scene.tethers.contains(scene.tether));
  CHECK(scene.rods.contains(scene.rod));
  CHECK(scene.shapes.contains({3, 0}));
  CHECK(scene.world.contact_source() == &scene.shapes);
  CHECK(future() == first);
}

TEST_CASE("world_copy: neither world knows of the other", "[collision][unit]") {
  Scene scene;
  Solver solver;
  steps(scene.world, solver, scene, 0, 30);
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  const auto before = scene.world.snapshot();
  World& world = copy.world();
  auto& shapes = dynamic_cast<CollisionScene&>(*world.contact_source());
  world.set_pose(scene.top, at(3, 3, 3));
  shapes.remove({4, 0});
  world.remove_body(scene.sleeper);
  steps(world, solver, scene, 30, 40);
  CHECK(scene.world.snapshot() == before);
  REQUIRE(copy.assign(scene.world));
  CHECK(same(world, scene.world));
  scene.world.remove_body(scene.sleeper);
  scene.world.set_gravity(Vec3::Zero());
  steps(scene.world, solver, scene, 30, 40);
  CHECK(world.snapshot() == before);
  // It outlives the original, and can be moved.
  WorldCopy moved;
  {
    Scene brief;
    REQUIRE(copy.assign(brief.world));
  }
  moved = std::move(copy);
  CHECK(copy.empty());
  CHECK(copy.world().contacts() == nullptr);
  steps(moved.world(), solver, scene, 0, 30);
  CHECK(moved.world().snapshot() == before);
}

TEST_CASE("world_copy: a sleeping body put elsewhere touches the bodies there",
          "[collision][regression]") {
  Fixture f;
  f.fixed(HalfSpace{});
  const BodyId box = f.add(Box{}, at(0, 0, 0.5));
  const BodyId other = f.add(Box{}, at(5, 0, 0.5));
  f.world.set_contact_source(&f.scene);
  Solver solver;
  for (int i = 0; i < 60; ++i) solver.step(f.world, kDt);
  REQUIRE_FALSE(f.world.awake(box));
  REQUIRE(f.world.contacts()->contacts().size() == 2);
  WorldCopy copy;
  REQUIRE(copy.assign(f.world));
  World& world = copy.world();
  const auto is_there = [&] {
    const auto contacts = world.contacts()->contacts();
    return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
      return c.manifold.body_a == box.index && c.manifold.body_b == other.index;
    });
  };
  solver.step(world, kDt);
  REQUIRE_FALSE(is_there());
  BodyState state = world.state(other);
  state.pose.position = world.pose(box).position + Vec3(0, 0, 1.0);
  copy.set_state(other.index, state, false);
  solver.step(world, kDt);
  CHECK(is_there());
  // It woke, or lies where it was put: nothing took it back.
  CHECK((world.pose(other).position - state.pose.position).norm() < 0.01);
}

TEST_CASE("world_copy: a copy follows targets of its own", "[collision][unit]") {
  Scene scene;
  tandem::testing::FixedTargets targets;
  targets.targets.push_back({.body = scene.heap,
                             .pose = at(0.3, 0.2, 3.0),
                             .share = 0.05,
                             .motion = TargetMotion::WithBody});
  scene.world.set_target_source(&targets);
  Solver solver;
  steps(scene.world, solver, scene, 0, 40);
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  CHECK(copy.world().target_source() == nullptr);
  copy.world().set_target_source(&targets);
  steps(scene.world, solver, scene, 40, 80);
  steps(copy.world(), solver, scene, 40, 80);
  CHECK(same(copy.world(), scene.world));
  copy.restore(scene.world);
  CHECK(scene.world.target_source() == &targets);
}

TEST_CASE("world_copy: assign() and restore() allocate only where the source has grown",
          "[collision][regression]") {
  Scene scene(true);
  Solver solver;
  steps(scene.world, solver, scene, 0, 200);
  scene.world.apply_force(scene.top, Vec3(1.0, 0.0, 0.0));
  WorldCopy copy;
  REQUIRE(copy.assign(scene.world));
  steps(copy.world(), solver, scene, 200, 210);
  const AllocationCount count;
  const bool done = copy.assign(scene.world);
  copy.restore(scene.world);
  const std::size_t counted = count.count();
  CHECK(done);
  CHECK(counted == 0);
}

}  // namespace world_copy_test
