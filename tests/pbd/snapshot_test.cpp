// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <memory>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world.h"

namespace snapshot_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// Boxes sliding and bouncing, a jointed pair, a rod, a spring, a user's tether and a freed slot:
/// all that a step depends on.
struct Scene {
  World world;
  ToyContacts contacts;
  Tethers* tethers = nullptr;
  ConstraintId tether;
  BodyId box;
  Solver solver;

  Scene() {
    world.set_contact_source(&contacts);
    auto& balls = world.add_block<JointBlock>();
    auto& rods = world.add_block<DistanceJoints>();
    tethers = &world.add_block<Tethers>();
    const Vec3 half(0.2, 0.3, 0.25);
    const BodyId gone = world.add_body({});
    const BodyId ground = add_ground(world);
    box = world.add_body(box_def(1.0, half, Vec3(0.0, 0.0, 0.3), turn(Vec3(0.1, 0.2, 0.0))));
    const BodyId b = world.add_body(box_def(2.0, half, Vec3(0.6, 0.0, 0.8)));
    const BodyId c = world.add_body(box_def(0.5, half, Vec3(1.2, 0.0, 1.2)));
    const BodyId ball = world.add_body(ball_def(0.3, 0.2, Vec3(-1.0, 0.0, 0.7)));
    world.remove_body(gone);
    for (const BodyId id : {box, b, c}) {
      contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, id, half, {.friction = 0.3});
    }
    contacts.ball_on_plane(ground, Vec3::UnitZ(), 0.0, ball, 0.2, {.restitution = 0.7});
    balls.add(world, ball_joint_at(world, b, c, Vec3(0.9, 0.0, 1.0)));
    rods.add(world, {.a = box, .b = b, .rest_length = 0.7});
    rods.add(world, {.a = ball, .b = box, .rest_length = 0.9, .compliance = 1e-2, .damping = 0.5});
    tether = tethers->add(world, {.body = c,
                                  .anchor_l = Vec3(0.1, 0.1, 0.1),
                                  .anchor_w = Vec3(1.0, 0.5, 1.5),
                                  .anchor_velocity = Vec3(-0.2, 0.1, 0.0)});
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) solver.step(world, kFrame);
  }
};

}  // namespace

TEST_CASE("snapshot: a restored world goes on bit for bit as the uninterrupted one",
          "[pbd][golden]") {
  Scene straight;
  int before = 40;
  straight.steps(before);
  // Carried multipliers are at stake.
  for (; before < 80 && !straight.world.in_contact(straight.box); ++before) straight.steps(1);
  REQUIRE(straight.world.in_contact(straight.box));
  const auto bytes = straight.world.snapshot();
  straight.steps(100);

  Scene back;  // the same world put back
  back.steps(before + 17);
  back.world.restore(bytes);
  CHECK(back.world.snapshot() == bytes);
  back.steps(100);
  CHECK(back.world.hash() == straight.world.hash());
  CHECK(back.world.time() == straight.world.time());

  Scene fresh;  // a world built anew, solved by another solver
  fresh.world.restore(bytes);
  CHECK(fresh.world.snapshot() == bytes);
  fresh.steps(100);
  CHECK(fresh.world.hash() == straight.world.hash());
  CHECK(fresh.world.snapshot() == straight.world.snapshot());
}

TEST_CASE("snapshot: so it does where the next step has another length", "[pbd][golden]") {
  Scene straight;
  straight.steps(40);
  Scene fresh;
  fresh.world.restore(straight.world.snapshot());
  for (const double dt : {0.5 * kFrame, 1.2 * kFrame}) {
    straight.solver.step(straight.world, dt);
    fresh.solver.step(fresh.world, dt);
    CHECK(fresh.world.hash() == straight.world.hash());
  }
}

TEST_CASE("snapshot: ids, generations and free slots come back", "[pbd][unit]") {
  Scene scene;
  const auto bytes = scene.world.snapshot();
  const BodyId expected = scene.world.add_body({});
  scene.tethers->remove(scene.tether);
  scene.world.restore(bytes);
  CHECK_FALSE(scene.world.contains(expected));
  CHECK(scene.world.contains(scene.box));
  CHECK(scene.tethers->contains(scene.tether));
  CHECK(scene.world.add_body({}) == expected);
}

TEST_CASE("snapshot: a tether that a peer moves on after the restore is the restored one",
          "[pbd][unit]") {
  Scene scene;
  scene.steps(5);
  const auto bytes = scene.world.snapshot();
  const Vec3 anchor = scene.tethers->def(scene.tether).anchor_w;
  // It moves with its velocity: 5 steps of 1/60 s.
  CHECK((anchor - Vec3(1.0 - 0.2 * 5 * kFrame, 0.5 + 0.1 * 5 * kFrame, 1.5)).norm() < 1e-14);
  scene.steps(5);
  scene.world.restore(bytes);
  CHECK(scene.tethers->def(scene.tether).anchor_w == anchor);
}

TEST_CASE("snapshot: cut short anywhere, it is refused and the world stays as it was",
          "[pbd][fault]") {
  Scene scene;
  scene.steps(20);
  const auto bytes = scene.world.snapshot();
  scene.steps(3);
  const auto before = scene.world.snapshot();
  for (std::size_t length = 0; length < bytes.size(); length += length < 256 ? 1 : 37) {
    const std::string message =
        refusal([&] { scene.world.restore(std::span(bytes).first(length)); });
    INFO("length " << length);
    REQUIRE(names(message, "World::restore", "bytes", "must be"));
    REQUIRE(scene.world.snapshot() == before);
  }
}

TEST_CASE("snapshot: with one byte damaged anywhere, it is refused and the world stays as it was",
          "[pbd][fault]") {
  Scene scene;
  scene.steps(20);
  const auto bytes = scene.world.snapshot();
  scene.steps(3);
  const auto before = scene.world.snapshot();
  for (std::size_t at = 0; at < bytes.size(); at += at < 256 ? 1 : 29) {
    auto damaged = bytes;
    damaged[at] ^= std::byte{0x10};
    INFO("byte " << at << " of " << bytes.size());
    REQUIRE_FALSE(refusal([&] { scene.world.restore(damaged); }).empty());
    REQUIRE(scene.world.snapshot() == before);
  }
}

TEST_CASE("snapshot: with bytes after its end, it is refused", "[pbd][fault]") {
  Scene scene;
  auto bytes = scene.world.snapshot();
  const auto before = bytes;
  bytes.push_back(std::byte{0});
  CHECK_FALSE(refusal([&] { scene.world.restore(bytes); }).empty());
  CHECK(scene.world.snapshot() == before);
}

TEST_CASE("snapshot: a world built otherwise refuses it", "[pbd][fault]") {
  Scene scene;
  const auto bytes = scene.world.snapshot();
  World empty;
  CHECK(names(refusal([&] { empty.restore(bytes); }), "World::restore", "bytes", "same blocks"));

  World three_blocks;  // the same number, other kinds, no source
  three_blocks.add_block<JointBlock>();
  three_blocks.add_block<DistanceJoints>();
  const auto other = three_blocks.snapshot();
  World swapped;
  swapped.add_block<JointBlock>();
  swapped.add_block<JointBlock>();
  const auto before = swapped.snapshot();
  CHECK(names(refusal([&] { swapped.restore(other); }), "World::restore", "bytes", "same blocks"));
  CHECK(swapped.snapshot() == before);
}

TEST_CASE("snapshot: the hash changes with any bit of any pose or twist", "[pbd][unit]") {
  Scene scene;
  scene.steps(10);
  const std::uint64_t before = scene.world.hash();
  CHECK(scene.world.hash() == before);
  const BodyState state = scene.world.state(scene.box);
  const auto nudged = [](double value) { return std::nextafter(value, 1e9); };
  std::vector<std::uint64_t> seen{before};
  for (int field = 0; field < 9; ++field) {
    BodyState changed = state;
    double& value = field < 3   ? changed.pose.position[field]
                    : field < 6 ? changed.twist.linear[field - 3]
                                : changed.twist.angular[field - 6];
    value = nudged(value);
    scene.world.set_pose(scene.box, {changed.pose.position, state.pose.orientation});
    scene.world.set_twist(scene.box, changed.twist);
    seen.push_back(scene.world.hash());
  }
  scene.world.set_twist(scene.box, state.twist);
  scene.world.set_pose(scene.box,
                       {state.pose.position, turn(Vec3(1e-12, 0.0, 0.0)) * state.pose.orientation});
  seen.push_back(scene.world.hash());
  std::sort(seen.begin(), seen.end());
  CHECK(std::adjacent_find(seen.begin(), seen.end()) == seen.end());
}

TEST_CASE("snapshot: the same inputs twice give the same bits, another input others",
          "[pbd][golden]") {
  Scene one;
  Scene two;
  Scene other;
  other.world.set_twist(other.box, {Vec3(1e-14, 0.0, 0.0), Vec3::Zero()});
  one.steps(120);
  two.steps(120);
  other.steps(120);
  CHECK(one.world.hash() == two.world.hash());
  CHECK(one.world.snapshot() == two.world.snapshot());
  CHECK(one.world.hash() != other.world.hash());
}

TEST_CASE("snapshot: an empty world has one too", "[pbd][unit]") {
  World world({.gravity = Vec3(1.0, 2.0, 3.0)});
  World other;
  other.restore(world.snapshot());
  CHECK(other.gravity() == Vec3(1.0, 2.0, 3.0));
  CHECK(other.body_count() == 0);
}

}  // namespace snapshot_test
