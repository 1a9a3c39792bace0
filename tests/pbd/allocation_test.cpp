// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstdlib>
#include <new>

#include "support/aligned_memory.h"
#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/smooth_poses.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world_copy.h"

// Every allocation of this executable comes through here.
namespace {
bool counting = false;
long allocations = 0;

void* allocate(std::size_t size) {
  if (counting) ++allocations;
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* allocate(std::size_t size, std::align_val_t alignment) {
  if (counting) ++allocations;
  void* memory = tandem::testing::aligned_memory(size, static_cast<std::size_t>(alignment));
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void* operator new(std::size_t size, std::align_val_t a) { return allocate(size, a); }
void* operator new[](std::size_t size, std::align_val_t a) { return allocate(size, a); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  if (counting) ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new[](std::size_t size, const std::nothrow_t& tag) noexcept {
  return operator new(size, tag);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { tandem::testing::free_aligned(p); }
void operator delete[](void* p, std::align_val_t) noexcept { tandem::testing::free_aligned(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  tandem::testing::free_aligned(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
  tandem::testing::free_aligned(p);
}

using namespace tandem::pbd;
using namespace tandem::testing;

TEST_CASE("allocation: the counter sees an allocation", "[pbd][unit]") {
  allocations = 0;
  counting = true;
  std::vector<int> numbers(10);
  counting = false;
  CHECK(allocations == 1);
  CHECK(numbers.size() == 10);
}

TEST_CASE("allocation: a step in the steady state makes none", "[pbd][regression]") {
  for (const int substeps : {1, 4, 10}) {
    World world;
    ToyContacts contacts;
    FixedTargets source;
    world.set_contact_source(&contacts);
    world.set_target_source(&source);
    auto& balls = world.add_block<JointBlock>();
    auto& rods = world.add_block<DistanceJoints>();
    auto& tethers = world.add_block<Tethers>();
    const BodyId ground = add_ground(world);
    const Vec3 half(0.5, 0.5, 0.5);
    BodyId below;
    for (int i = 0; i < 6; ++i) {
      const BodyId box = world.add_body(box_def(1.0, half, Vec3(0.01 * i, 0.0, 0.5 + i)));
      if (i == 0) {
        contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, half, {});
      } else {
        contacts.box_on_box(below, half, box, half, {});
      }
      if (i == 5) {
        tethers.add(world, {.body = box, .anchor_w = Vec3(0.1, 0.1, 5.6), .stiffness = 50.0});
        const BodyId hung = world.add_body(box_def(1.0, half, Vec3(3.0, 0.0, 5.0)));
        const BodyId ball = world.add_body(ball_def(1.0, 0.3, Vec3(5.0, 0.0, 5.0)));
        balls.add(world, ball_joint_at(world, {}, hung, Vec3(3.0, 0.0, 7.0)));
        rods.add(world, {.a = hung, .b = ball, .rest_length = 2.0});
      }
      source.targets.push_back(
          {.body = box,
           .pose = {world.pose(box).position + Vec3(0.002, 0.0, 0.0), Quat::Identity()},
           .share = 0.05});
      below = box;
    }
    Solver solver({.substeps = substeps});
    for (int k = 0; k < 30; ++k) solver.step(world, kFrame);  // room for all is made here
    allocations = 0;
    counting = true;
    for (int k = 0; k < 200; ++k) solver.step(world, kFrame);
    counting = false;
    CHECK(allocations == 0);
    REQUIRE(world.contacts()->contacts().size() == 6);
  }
}

TEST_CASE("allocation: a world that is copied and restored again makes none", "[pbd][regression]") {
  World world;
  auto& balls = world.add_block<JointBlock>();
  auto& rods = world.add_block<DistanceJoints>();
  auto& tethers = world.add_block<Tethers>();
  BodyId before;
  for (std::uint64_t i = 0; i < 8; ++i) {
    BodyDef def = ball_def(1.0, 0.1, Vec3(0.3 * static_cast<double>(i), 0.0, 5.0));
    def.stable_id = 100 - i;
    const BodyId ball = world.add_body(def);
    balls.add(world, ball_joint_at(world, before, ball, def.pose.position));
    if (before.valid()) rods.add(world, {.a = before, .b = ball, .compliance = 1e-3});
    tethers.add(world, {.body = ball, .anchor_w = def.pose.position});
    before = ball;
  }
  Solver solver;
  for (int k = 0; k < 10; ++k) solver.step(world, kFrame);
  world.apply_force(before, Vec3(1.0, 0.0, 0.0));
  WorldCopy copy;
  REQUIRE(copy.assign(world));
  allocations = 0;
  counting = true;
  bool all = true;
  for (int k = 0; k < 20; ++k) {
    all = copy.assign(world) && all;
    solver.step(copy.world(), kFrame);
    copy.restore(world);
  }
  counting = false;
  CHECK(all);
  CHECK(allocations == 0);
}

TEST_CASE("allocation: showing bodies between steps makes none", "[pbd][smooth]") {
  World world;
  Solver solver;
  const BodyId ball = world.add_body({});
  SmoothPoses shown;
  solver.step(world, 1.0 / 60.0);
  shown.after_step(world, 1.0 / 60.0);
  allocations = 0;
  counting = true;
  double sum = 0.0;
  for (int i = 0; i < 60; ++i) {
    solver.step(world, 1.0 / 60.0);
    shown.after_step(world, 1.0 / 60.0);
    sum += shown.at(ball, 0.5).position.z();
  }
  counting = false;
  CHECK(allocations == 0);
  CHECK(sum < 0.0);
}

// It looks at what touches the body, not at a list of all that touches.
TEST_CASE("allocation: to set a body that others touch makes none", "[pbd][regression]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  auto& rods = world.add_block<DistanceJoints>();
  const BodyId ground = add_ground(world);
  const BodyId lift = world.add_body({.type = BodyType::Kinematic});
  const Vec3 half(0.5, 0.5, 0.5);
  for (int i = 0; i < 50; ++i) {
    const BodyId box = world.add_body(box_def(1.0, half, Vec3(2.0 * i, 0.0, 0.5)));
    contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, half, {});
    rods.add(world, {.a = lift, .b = box, .compliance = 1.0});
  }
  Solver solver;
  const auto set_all = [&] {
    world.set_pose(ground, {});
    world.set_twist(lift, {});
    world.set_kinematic_target(lift, {});
  };
  for (int k = 0; k < 3; ++k) {
    solver.step(world, kFrame);
    set_all();
  }
  for (int k = 0; k < 3; ++k) {
    solver.step(world, kFrame);
    allocations = 0;
    counting = true;
    set_all();
    counting = false;
    CHECK(allocations == 0);
  }
}

TEST_CASE("allocation: a motor that is switched on or off makes none", "[pbd][regression]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  std::vector<std::pair<JointId, HingeJointDef>> hinges;
  BodyId before;
  for (int i = 0; i < 20; ++i) {
    const BodyId link = world.add_body(ball_def(1.0, 0.1, Vec3(0.3 * i, 0.0, 0.0)));
    const Vec3 at(0.3 * i - 0.15, 0.0, 0.0);
    const HingeJointDef def = hinge_joint_at(world, before, link, at, Vec3::UnitY());
    hinges.emplace_back(joints.add(world, def), def);
    before = link;
  }
  Solver solver;
  for (int k = 0; k < 10; ++k) solver.step(world, kFrame);
  const auto set_motors = [&](bool run) {
    for (auto& [id, def] : hinges) {
      def.axis.motor.mode = run ? MotorMode::Velocity : MotorMode::Off;
      joints.set(world, id, def);
    }
  };
  set_motors(true);
  solver.step(world, kFrame);  // room for the list of what was changed
  allocations = 0;
  counting = true;
  for (int k = 0; k < 20; ++k) {
    set_motors(k % 2 == 1);
    solver.step(world, kFrame);
  }
  counting = false;
  CHECK(allocations == 0);
}
