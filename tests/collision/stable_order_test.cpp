// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "fixture.h"
#include "support/bodies.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace stable_order_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using namespace tandem::pbd;
using tandem::testing::names;
using tandem::testing::refusal;

namespace {

constexpr std::size_t kBodies = 40;
constexpr std::size_t kJointed = 23;
constexpr std::size_t kGround = kBodies;  // two meshes side by side, and a plane below
constexpr std::size_t kAll = kBodies + 3;

/// A heap of seven kinds of shapes, compounds among them, with joints of several kinds, on a mesh.
/// Everything is added in an order that the seed gives; 0 is the order of numbers.
struct Scene {
  World world;
  CollisionScene shapes;
  std::vector<BodyId> ids = std::vector<BodyId>(kAll);
  Solver solver;

  Scene(std::uint64_t seed, bool named, int threads = 1) : solver({.threads = threads}) {
    world.set_contact_source(&shapes);
    auto& rods = world.add_block<DistanceJoints>();
    auto& joints = world.add_block<JointBlock>();
    // Drawn before anything is shuffled, so that all seeds have the same scene.
    Random random(41);
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < kBodies; ++i) {
      const Vec3 p(random.in(-0.8, 0.8), random.in(-0.8, 0.8), 0.4 + 0.1 * double(i));
      poses.push_back({p, random.quat()});
      // A few boxes lie apart from the heap, free of joints, and fall asleep.
      if (i > kJointed && i % 7 >= 5) poses.back() = at(0.6 * double(i) - 20.0, 4.0, 0.15);
    }
    std::mt19937_64 order(seed);
    const auto shuffled = [&](std::size_t count) {
      std::vector<std::size_t> list(count);
      std::iota(list.begin(), list.end(), std::size_t{0});
      for (std::size_t i = count; seed != 0 && i > 1; --i)
        std::swap(list[i - 1], list[order() % i]);
      return list;
    };
    for (const std::size_t i : shuffled(kAll)) {
      BodyDef def;
      // Neither dense nor small, and not the order of the numbers.
      if (named) def.stable_id = (0x9e3779b97f4a7c15u * (i + 1)) ^ 0xabcdefu;
      if (i < kBodies) {
        const auto properties = mass_properties(shape_of(i), 400.0);
        def.pose = poses[i];
        if (i % 11 == 3) def.twist.linear = Vec3(0.0, 0.0, -40.0);  // stopped on its way
        def.bullet = i % 9 == 3;
        def.mass = properties.mass * (i % 5 == 0 ? 8.0 : 1.0);
        def.inertia = properties.inertia * (i % 5 == 0 ? 8.0 : 1.0);
      } else {
        def.type = BodyType::Static;
        if (i == kAll - 1) def.pose.position.z() = -1.0;
        if (i < kAll - 1) def.pose.position.x() = i == kGround ? -5.0 : 5.0;
      }
      ids[i] = world.add_body(def);
    }
    const Mesh floor = flat_mesh(10.0, 9);
    for (const std::size_t i : shuffled(kAll)) {
      ColliderDef def{.body = ids[i], .material = {.friction = i % 4 == 0 ? 0.0 : 0.6}};
      if (i % 6 == 0) def.material.restitution = 0.4;
      if (i < kBodies) {
        def.shape = shape_of(i);
        shapes.add(world, def);
        if (i % 8 != 1) continue;
        def.shape = Sphere{0.12};  // a second one, always after the first
        def.local.position = Vec3(0.25, 0.0, 0.0);
        shapes.add(world, def);
      } else if (i == kAll - 1) {
        def.shape = HalfSpace{};
        shapes.add(world, def);
      } else {
        def.shape = floor;
        shapes.add(world, def);
      }
    }
    for (const std::size_t k : shuffled(kJointed / 2)) {
      const BodyId a = ids[2 * k];
      const BodyId b = ids[2 * k + 3];
      const BodyId c = ids[(7 * k + 5) % kJointed];
      const Vec3 middle = 0.5 * (world.pose(a).position + world.pose(b).position);
      const double length = (world.pose(a).position - world.pose(b).position).norm();
      if (k % 3 == 0) {
        joints.add(world, ball_joint_at(world, a, b, middle));
      } else if (k % 3 == 1) {
        rods.add(world, {.a = a, .b = b, .rest_length = length});
        if (c != a) rods.add(world, {.a = c, .b = a, .rest_length = 1.0, .compliance = 1e-3});
      } else {
        joints.add(world, joint_at(a, b, middle));
      }
    }
    // A chain that hangs on the world, with two loops.
    const std::array<std::size_t, 8> chain{39, 28, 36, 30, 37, 31, 35, 29};
    for (const std::size_t k : shuffled(chain.size() + 2)) {
      const BodyId a = k == 0 ? BodyId{} : ids[chain[k < 9 ? k - 1 : 2]];
      const BodyId b = ids[chain[k < 8 ? k : k == 8 ? 4 : 6]];
      const Vec3 end = world.pose(b).position + Vec3(1.0, 0.0, 0.5);
      const Vec3 middle =
          a.valid() ? Vec3(0.5 * (world.pose(a).position + world.pose(b).position)) : end;
      joints.add(world, joint_at(a, b, middle));
    }
  }

  SixDofJointDef joint_at(BodyId a, BodyId b, const Vec3& anchor_w) const {
    SixDofJointDef def;
    def.a = a;
    def.b = b;
    def.frame_a.anchor = a.valid() ? world.pose(a).to_local(anchor_w) : anchor_w;
    def.frame_b.anchor = world.pose(b).to_local(anchor_w);
    for (JointAxis& axis : def.linear) axis.freedom = Freedom::Locked;
    return def;
  }

  static Shape shape_of(std::size_t i) {
    static const std::vector<Vec3> kCorners{Vec3(0.3, 0, -0.1), Vec3(-0.2, 0.25, -0.1),
                                            Vec3(-0.2, -0.25, -0.1), Vec3(0, 0, 0.3)};
    switch (i % 7) {
      case 0:
        return Sphere{0.2};
      case 1:
        return Capsule{0.12, 0.2};
      case 2:
        return Cylinder{0.2, 0.15};
      case 3:
        return Cone{0.2, 0.2};
      case 4:
        return ConvexHull::make(kCorners);
      default:
        return Box{Vec3(0.2, 0.25, 0.15)};
    }
  }

  /// Poses, velocities and sleep of all bodies, by number.
  std::vector<std::byte> bits() const {
    std::vector<std::byte> bytes;
    ByteWriter out(bytes);
    for (const BodyId id : ids) {
      out.vec3(world.pose(id).position);
      out.quat(world.pose(id).orientation);
      out.vec3(world.twist(id).linear);
      out.vec3(world.twist(id).angular);
      out.u8(world.awake(id) ? 1 : 0);
      out.u8(world.in_contact(id) ? 1 : 0);
    }
    return bytes;
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) solver.step(world, kDt);
  }
};

}  // namespace

TEST_CASE("order: a scene built in another order moves alike bit for bit",
          "[collision][golden][long]") {
  Scene straight(0, true);
  std::vector<Scene> others;
  others.reserve(2);
  others.emplace_back(1u, true);
  others.emplace_back(3u, true, 2);  // on two threads
  int sleepers = 0;
  for (int i = 0; i < 12; ++i) {
    straight.steps(20);
    for (std::size_t k = 0; k < others.size(); ++k) {
      others[k].steps(20);
      INFO("after " << 20 * (i + 1) << " steps, other " << k);
      REQUIRE(others[k].bits() == straight.bits());
    }
  }
  CHECK(straight.world.contacts()->contacts().size() > 30);
  for (const BodyId id : straight.ids) sleepers += straight.world.awake(id) ? 0 : 1;
  CHECK(sleepers > 0);
}

TEST_CASE("order: without stable ids it does not, so that the test above can fail",
          "[collision][golden][long]") {
  Scene straight(0, false);
  Scene other(1, false);
  straight.steps(120);
  other.steps(120);
  CHECK(straight.bits() != other.bits());
}

TEST_CASE("order: stable ids in the order of slots, and bodies without any, change no bit",
          "[collision][golden]") {
  // Collider by collider next to its body, as most scenes are built.
  const auto run = [](bool named) {
    Fixture f;
    Random random(3);
    f.world.set_contact_source(&f.scene);
    std::vector<BodyId> ids;
    for (std::uint64_t i = 0; i < 30; ++i) {
      BodyDef def;
      if (i == 0) def.type = BodyType::Static;
      if (i > 0) def.pose = {random.vec(0.5) + Vec3(0, 0, 0.5 + 0.15 * double(i)), random.quat()};
      if (named) def.stable_id = 1000 + 7 * i;
      ids.push_back(f.world.add_body(def));
      f.scene.add(f.world,
                  {.body = ids.back(),
                   .shape = i == 0 ? Shape(HalfSpace{}) : Shape(Box{Vec3::Constant(0.2)})});
    }
    Solver solver;
    for (int i = 0; i < 120; ++i) solver.step(f.world, kDt);
    return f.world.hash();
  };
  CHECK(run(true) == run(false));
}

TEST_CASE("order: bodies and joints that come and go later keep the others' places",
          "[collision][golden][long]") {
  Scene straight(0, true);
  Scene other(5, true);
  const auto change = [](Scene& s, bool reverse) {
    s.world.remove_body(s.ids[10]);
    s.world.remove_body(s.ids[11]);
    const auto add = [&](std::size_t i) {
      BodyDef def{.pose = {.position = Vec3(0.1 * double(i), 0.0, 6.0)}, .stable_id = 77 * i};
      s.ids[i] = s.world.add_body(def);
      s.shapes.add(s.world, {.body = s.ids[i], .shape = Box{Vec3::Constant(0.15)}});
    };
    add(reverse ? 11 : 10);
    add(reverse ? 10 : 11);
  };
  straight.steps(60);
  other.steps(60);
  change(straight, false);
  change(other, true);
  for (int i = 0; i < 6; ++i) {
    straight.steps(20);
    other.steps(20);
    REQUIRE(other.bits() == straight.bits());
  }
}

TEST_CASE("order: a stable id finds its body and comes back with a snapshot", "[collision][unit]") {
  World world;
  const BodyId a = world.add_body({.stable_id = 900});
  const BodyId b = world.add_body({});
  const BodyId c = world.add_body({.stable_id = 17});
  CHECK(world.find(900) == a);
  CHECK(world.find(17) == c);
  CHECK_FALSE(world.find(1).valid());
  CHECK(world.props(b).stable_id == std::nullopt);
  // Bodies with an id first, by id; then the others.
  CHECK(world.order().slot(0) == c.index);
  CHECK(world.order().slot(1) == a.index);
  CHECK(world.order().rank(b.index) == 2);
  const auto bytes = world.snapshot();
  world.remove_body(a);
  CHECK_FALSE(world.find(900).valid());
  const BodyId again = world.add_body({.stable_id = 900});
  CHECK(world.find(900) == again);
  world.restore(bytes);
  CHECK(world.find(900) == a);
  CHECK(world.snapshot() == bytes);
}

TEST_CASE("order: a stable id that is taken is refused with its name, value and rule",
          "[collision][fault]") {
  World world;
  world.add_body({.stable_id = 4711});
  const std::string message = refusal([&] { world.add_body({.stable_id = 4711}); });
  CHECK(names(message, "stable_id", "4711", "no other body"));
  CHECK(world.body_count() == 1);
  CHECK_NOTHROW(world.add_body({.stable_id = 4712}));
}

}  // namespace stable_order_test
