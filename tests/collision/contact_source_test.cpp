// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_source.h"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <set>
#include <utility>

#include "allocation_count.h"
#include "fixture.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world_copy.h"

namespace contact_source_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;
using tandem::pbd::Twist;
namespace pbd = tandem::pbd;

TEST_CASE("contact_source: input that cannot be is refused by name, value and rule",
          "[collision][fault]") {
  Fixture f;
  ColliderDef def;
  def.body = f.body({});
  def.shape = Sphere{0.5};
  const auto refused = [&](auto&& change) {
    ColliderDef bad = def;
    change(bad);
    try {
      f.scene.add(f.world, bad);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK_THAT(refused([](ColliderDef& d) {
               d.body = {7, 3};
             }),
             Contains("body must be") && Contains("is body 7"));
  CHECK_THAT(refused([](ColliderDef& d) { d.shape = Sphere{-2}; }),
             Contains("Sphere.radius must be") && Contains("is -2") && Contains("> 0"));
  CHECK_THAT(refused([](ColliderDef& d) { d.material.friction = -0.1; }),
             Contains("friction must be") && Contains("is -0.1") && Contains(">= 0"));
  CHECK_THAT(refused([](ColliderDef& d) { d.material.restitution = 1.5; }),
             Contains("restitution must be") && Contains("is 1.5") && Contains("0 to 1"));
  CHECK_THAT(refused([](ColliderDef& d) { d.local.position.y() = NAN; }),
             Contains("local.position must be") && Contains("is nan"));
  CHECK_THAT(refused([](ColliderDef& d) { d.local.orientation.w() = 2; }),
             Contains("local.orientation must be") && Contains("is 2"));
  CHECK(f.scene.slot_count() == 0);

  CollisionOptions options;
  options.recycle_angle = 1.0;
  CHECK_THROWS_WITH(CollisionScene(options),
                    Contains("recycle_angle must be") && Contains("is 1") && Contains("0 to 0.2"));
  options = {};
  options.speculative_margin = NAN;
  CHECK_THROWS_WITH(CollisionScene(options), Contains("speculative_margin"));

  const ColliderId id = f.scene.add(f.world, def);
  CHECK(f.scene.contains(id));
  CHECK(std::get<Sphere>(f.scene.collider(id).shape).radius == 0.5);
  f.scene.remove(id);
  CHECK_THROWS_WITH(f.scene.remove(id), Contains("collider 0"));
  CHECK_THROWS_WITH(f.scene.collider(id), Contains("collider 0"));
  CHECK_FALSE(f.scene.contains(f.scene.collider_at(0)));
}

TEST_CASE("contact_source: friction combines by the geometric mean, restitution by the larger",
          "[collision][unit]") {
  Fixture f;
  ColliderDef def;
  def.shape = Sphere{0.5};
  def.body = f.body(at(0, 0, 0));
  def.material.friction = 0.2;
  def.material.restitution = 0.1;
  f.scene.add(f.world, def);
  def.body = f.body(at(0.9, 0, 0));
  def.material.friction = 0.8;
  def.material.restitution = 0.6;
  f.scene.add(f.world, def);
  REQUIRE(f.collect().size() == 1);
  CHECK(f.manifolds[0].friction == Approx(0.4));
  CHECK(f.manifolds[0].restitution == 0.6);
}

TEST_CASE("contact_source: filters, one body's parts and immovable pairs make no contacts",
          "[collision][unit]") {
  Fixture f;
  ColliderDef def;
  def.shape = Sphere{0.5};
  def.body = f.body(at(0, 0, 0));
  f.scene.add(f.world, def);
  def.local.position.x() = 0.3;
  f.scene.add(f.world, def);  // same body
  CHECK(f.collect().empty());
  def.local = {};
  def.body = f.body(at(0, 0.6, 0));
  def.filter.category = 2;
  def.filter.mask = 2;
  f.scene.add(f.world, def);  // sees only category 2
  CHECK(f.collect().empty());
  def.body = f.body(at(0, 1.2, 0), BodyType::Static);
  def.filter.mask = 1 | 2;
  f.scene.add(f.world, def);
  def.body = f.body(at(0, 0.6, 0.9), BodyType::Kinematic);
  f.scene.add(f.world, def);
  CHECK(f.collect().size() == 2);  // the third ball with each of the last two
}

TEST_CASE("contact_source: removed bodies and colliders leave no contacts", "[collision][unit]") {
  Fixture f;
  f.world.set_contact_source(&f.scene);
  f.fixed(HalfSpace{});
  const BodyId a = f.add(Sphere{0.5}, at(0, 0, 0.5));
  const BodyId b = f.add(Sphere{0.5}, at(0, 0, 1.5));
  CHECK(f.collect().size() == 2);
  f.world.remove_body(a);
  CHECK(f.collect().empty());
  CHECK(f.scene.stats().colliders == 2);
  const BodyId c = f.add(Sphere{0.5}, at(0.1, 0, 0.6));
  CHECK(c.index == a.index);  // the slots are used again
  CHECK(f.scene.slot_count() == 3);
  REQUIRE(f.collect().size() == 1);
  CHECK(f.manifolds[0].body_b == b.index);
}

TEST_CASE("contact_source: the broad phase misses no pair that all-against-all finds",
          "[collision][unit]") {
  Fixture f;
  Random random(4);
  std::vector<BodyId> balls;
  for (int i = 0; i < 120; ++i) {
    const double radius = random.in(0.05, 0.4);
    balls.push_back(f.add(Sphere{radius}, {random.vec(2.0), Quat::Identity()}));
    f.world.set_twist(balls.back(), {random.vec(4.0), random.vec(2.0)});
  }
  for (int step = 0; step < 60; ++step) {
    f.collect();
    std::set<std::pair<std::uint32_t, std::uint32_t>> found;
    for (const Manifold& m : f.manifolds) found.emplace(m.body_a, m.body_b);
    int expected = 0;
    for (std::size_t i = 0; i < balls.size(); ++i) {
      for (std::size_t j = i + 1; j < balls.size(); ++j) {
        const double radii =
            std::get<Sphere>(f.scene.collider(f.scene.collider_at(balls[i].index)).shape).radius +
            std::get<Sphere>(f.scene.collider(f.scene.collider_at(balls[j].index)).shape).radius;
        const double gap =
            (f.world.pose(balls[i]).position - f.world.pose(balls[j]).position).norm() - radii;
        if (gap >= 0.0) continue;
        ++expected;
        CHECK(found.count({balls[i].index, balls[j].index}) == 1);
      }
    }
    CHECK(expected > 0);
    CHECK(std::is_sorted(f.manifolds.begin(), f.manifolds.end(),
                         [](const Manifold& l, const Manifold& r) { return l.key < r.key; }));
    for (const BodyId id : balls) {
      Pose pose = f.world.pose(id);
      Twist twist = f.world.twist(id);
      for (int k = 0; k < 3; ++k) {
        if (std::abs(pose.position[k]) > 2.0) twist.linear[k] *= pose.position[k] > 0 ? -1 : 1;
        if (pose.position[k] * twist.linear[k] < -9.0) twist.linear[k] = 1.0;
      }
      pose.position += kDt * twist.linear;
      f.world.set_pose(id, pose);
      f.world.set_twist(id, twist);
    }
  }
}

TEST_CASE("contact_source: a pose that is no number makes no contact and no crash",
          "[collision][fault]") {
  Fixture f;
  f.fixed(flat_mesh(10.0, 3));
  const BodyId a = f.add(Box{Vec3::Constant(0.5)}, at(0, 0, 0.5));
  f.add(Sphere{0.5}, at(2, 0, 0.5));
  CHECK(f.collect().size() == 2);
  f.world.set_twist(a, {Vec3(1e200, 0, 0), Vec3(0, 0, 1e200)});  // squares to infinity
  f.collect();
  for (const Manifold& m : f.manifolds) CHECK(m.normal.allFinite());
  f.world.set_twist(a, {});
  CHECK(f.collect().size() == 2);
}

TEST_CASE("contact_source: a half-space that is moved meets bodies that are not",
          "[collision][unit]") {
  Fixture f;
  f.add(Sphere{0.5}, at(0, 0, 3));
  const BodyId floor = f.add(HalfSpace{}, {}, BodyType::Kinematic);
  CHECK(f.collect().empty());
  f.world.set_pose(floor, at(0, 0, 2.49));
  REQUIRE(f.collect().size() == 1);
  CHECK(f.gap(f.manifolds[0], 0) == Approx(0.01));
  f.world.set_pose(floor,
                   at(Vec3::Zero(), Vec3(0, std::numbers::pi / 2, 0)));  // now a wall facing +x
  REQUIRE(f.collect().size() == 1);
  CHECK((f.manifolds[0].normal + Vec3::UnitX()).norm() < 1e-9);
}

TEST_CASE("contact_source: parts of a body are placed by their local poses", "[collision][unit]") {
  Fixture f;
  f.fixed(HalfSpace{});
  ColliderDef def;
  def.body = f.body(at(Vec3(1, 2, 3), Vec3(0, 0, std::numbers::pi / 2)));
  def.shape = Sphere{0.5};
  def.local = at(1, 0, -2.51);
  f.scene.add(f.world, def);
  REQUIRE(f.collect().size() == 1);
  const Manifold& m = f.manifolds[0];
  CHECK((f.on_b(m, 0) - Vec3(1, 3, 0.49)).norm() < 1e-12);
  CHECK((m.points[0].anchor_b_l - Vec3(1, 0, -2.51)).norm() < 1e-12);
  CHECK(f.gap(m, 0) == Approx(-0.01));
}

TEST_CASE("contact_source: a collider or a filter that makes sleeping bodies overlap wakes them",
          "[collision][unit]") {
  for (const bool by_filter : {false, true}) {
    Fixture f;
    const BodyId floor = f.fixed(HalfSpace{});
    const BodyId box = f.add(Box{Vec3::Constant(0.25)}, at(0, 0, 0.25));
    ColliderDef step{.body = floor, .shape = Box{Vec3(1.0, 1.0, 0.05)}};
    step.filter.mask = 0;
    ColliderId id;
    if (by_filter) id = f.scene.add(f.world, step);
    f.world.set_contact_source(&f.scene);
    tandem::pbd::Solver solver;
    for (int i = 0; i < 120; ++i) solver.step(f.world, kDt);
    REQUIRE_FALSE(f.world.awake(box));
    step.filter = {};
    if (by_filter) {
      f.scene.set_filter(id, step.filter);
    } else {
      f.scene.add(f.world, step);
    }
    for (int i = 0; i < 60; ++i) solver.step(f.world, kDt);
    CHECK(f.world.pose(box).position.z() == Approx(0.3).margin(1e-3));
  }
}

TEST_CASE("contact_source: a collider may be made like another one of the scene",
          "[collision][unit]") {
  Fixture f;
  const std::vector<tandem::pbd::Vec3> corners{
      {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  const auto hull = ConvexHull::make(corners);
  const ColliderId first = f.scene.add(
      f.world, {.body = f.body({}), .shape = hull, .local = {.position = {1.0, 2.0, 3.0}}});
  // Each time from where it was before there was room for one more.
  for (int i = 0; i < 100; ++i) {
    const ColliderId id = f.scene.add(f.world, f.scene.collider(first));
    REQUIRE(std::get<Hull>(f.scene.collider(id).shape) == hull);
    REQUIRE(f.scene.collider(id).local.position == tandem::pbd::Vec3(1.0, 2.0, 3.0));
  }
}

// To clear a heap of n bodies of m would else be work of n m: 3 ms for each of 500 out of 7840.
TEST_CASE("contact_source: to remove a body is no work over the others",
          "[collision][regression]") {
  const auto allocations = [](int side) {
    Fixture f;
    f.world.set_contact_source(&f.scene);
    f.fixed(HalfSpace{});
    std::vector<BodyId> boxes;
    for (int i = 0; i < side * side * 2; ++i) {
      boxes.push_back(f.add(Box{0.5, 0.5, 0.5},
                            at(i % side, i / 2 / side, 0.5 + static_cast<double>(i / side % 2))));
    }
    pbd::Solver solver;
    for (int k = 0; k < 3; ++k) solver.step(f.world, kDt);
    f.world.remove_body(boxes[0]);
    const AllocationCount count;
    for (std::size_t i = 1; i < 11; ++i) f.world.remove_body(boxes[i]);
    return count.count();
  };
  CHECK(allocations(6) == allocations(20));
}

TEST_CASE("contact_source: beside a plane at rest the length of steps is of no matter",
          "[collision][regression]") {
  Fixture f;
  f.fixed(HalfSpace{});
  for (int i = 0; i < 30; ++i) f.add(Box{0.5, 0.5, 0.5}, at(2.0 * i, 0.0, 0.5));
  CHECK(f.collect().size() == 30);
  CHECK(f.scene.stats().searches == 30);
  for (const double dt : {1.0 / 60.0, 1.0 / 50.0, 1.0 / 90.0, 1.0 / 61.0}) {
    CHECK(f.collect(dt).size() == 30);
    CHECK(f.scene.stats().searches == 0);
  }
}

TEST_CASE("contact_source: reserved memory does not grow later", "[collision][unit]") {
  const auto build = [](bool room) {
    Fixture f;
    const AllocationCount count;
    if (room) f.world.reserve(500);
    if (room) f.scene.reserve(500);
    for (int i = 0; i < 500; ++i) f.fixed(Box{0.5, 0.5, 0.5}, at(i, 0.0, 0.0));
    f.add(Sphere{0.4}, at(3.0, 0.0, 1.0));
    f.world.set_contact_source(&f.scene);
    const std::size_t grown = count.count();
    pbd::Solver solver;
    for (int k = 0; k < 60; ++k) solver.step(f.world, kDt);
    return std::pair(grown, f.world.hash());
  };
  const auto [grown, hash] = build(false);
  const auto [less, same] = build(true);
  CHECK(less < grown);
  CHECK(same == hash);
}

TEST_CASE(
    "contact_source: a level that is under way allocates nothing, neither beside a plane that "
    "moves nor where "
    "copies of it go back",
    "[collision][regression]") {
  for (const bool plane_moves : {false, true}) {
    Fixture f;
    for (int i = 0; i < 10000; ++i) f.fixed(Box{0.5, 0.5, 0.5}, at(i % 100, i / 100, 0.0));
    for (int i = 0; i < 5; ++i) f.add(Sphere{0.4}, at(3.0 * i, 5.0, 1.0 + 0.5 * i));
    const BodyId lift = f.add(HalfSpace{}, at(0.0, 0.0, -40.0), BodyType::Kinematic);
    f.world.set_contact_source(&f.scene);
    pbd::Solver solver;
    pbd::Solver other;
    pbd::WorldCopy copy;
    const auto steps = [&](int count) {
      bool copied = true;
      for (int k = 0; k < count; ++k) {
        if (plane_moves) f.world.set_twist(lift, {Vec3(0.0, 0.0, 0.1 + 0.001 * k), Vec3::Zero()});
        solver.step(f.world, kDt);
        copied = copied && copy.assign(f.world);
        other.step(copy.world(), kDt);
        copy.restore(f.world);
      }
      return copied;
    };
    CHECK(steps(90));
    const AllocationCount count;
    const bool copied = steps(30);
    const std::size_t counted = count.count();
    CHECK(copied);
    CHECK(counted == 0);
  }
}

// The solver has what does not move only once something names it: what it had of a body that went,
// or no longer moves, is of no matter.
TEST_CASE("contact_source: a solver that has seen more gives the same bits",
          "[collision][regression]") {
  const auto run = [](bool named, bool anew) {
    Fixture f;
    f.world.set_contact_source(&f.scene);
    std::uint64_t id = 100;
    const auto add = [&](const Shape& shape, const Pose& pose, BodyType type) {
      BodyDef def{.type = type, .pose = pose};
      if (named) def.stable_id = --id;
      const BodyId body = f.world.add_body(def);
      f.scene.add(f.world, {.body = body, .shape = shape});
      return body;
    };
    std::vector<BodyId> tiles;
    for (int i = 0; i < 9; ++i) {
      tiles.push_back(add(Box{0.5, 0.5, 0.5}, at(i % 3, i / 3, -0.5), BodyType::Static));
    }
    std::vector<BodyId> boxes;
    for (int i = 0; i < 12; ++i) {
      boxes.push_back(
          add(Box{0.2, 0.2, 0.2}, at(0.1 * i, 0.3 + 0.03 * i, 0.25 + 0.41 * i), BodyType::Dynamic));
    }
    pbd::Solver solver;
    for (int k = 0; k < 120; ++k) {
      if (k == 40) f.world.remove_body(boxes[5]);
      if (k == 50) f.world.set_type(boxes[2], BodyType::Static);
      if (k == 70) f.world.set_pose(tiles[4], at(1.0, 1.0, -0.45));
      if (k == 80) f.world.set_mass(boxes[2], 1.0, 0.03 * pbd::Mat3::Identity());
      if (anew) {
        pbd::Solver().step(f.world, kDt);
      } else {
        solver.step(f.world, kDt);
      }
    }
    return f.world.hash();
  };
  for (const bool named : {false, true}) CHECK(run(named, false) == run(named, true));
}

}  // namespace contact_source_test
