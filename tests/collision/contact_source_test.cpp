// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_source.h"

#include <algorithm>
#include <set>

#include "allocation_count.h"
#include "fixture.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/solver.h"

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;
using tandem::pbd::ByteReader;
using tandem::pbd::ByteWriter;
using tandem::pbd::Solver;
using tandem::pbd::Twist;

namespace {

std::vector<std::byte> bytes_of(const std::vector<Manifold>& manifolds) {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  for (const Manifold& m : manifolds) {
    out.u64(m.key);
    out.u32(m.body_a);
    out.u32(m.body_b);
    out.vec3(m.normal);
    out.f64(m.radius_a);
    out.f64(m.radius_b);
    out.f64(m.friction);
    out.f64(m.restitution);
    for (int i = 0; i < m.count; ++i) {
      out.vec3(m.points[i].anchor_a_l);
      out.vec3(m.points[i].anchor_b_l);
      out.u32(m.points[i].feature);
    }
  }
  return bytes;
}

/// Many kinds of bodies falling onto a floor of the given kind.
void fill(Fixture& f, const Shape& ground, int count, std::uint64_t seed) {
  f.fixed(ground);
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const Shape shape = i % 3 == 0   ? Shape(Sphere{0.2})
                        : i % 3 == 1 ? Shape(Box{Vec3(0.2, 0.25, 0.15)})
                                     : Shape(Capsule{0.15, 0.2});
    const Vec3 p = random.vec(1.0) + Vec3(0, 0, 1.5 + 0.1 * i);
    f.add(shape, {p, random.quat()});
  }
  f.world.set_contact_source(&f.scene);
}

}  // namespace

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
  CHECK_THAT(refused([](ColliderDef& d) { d.body = {7, 3}; }), Contains("body = 7"));
  CHECK_THAT(refused([](ColliderDef& d) { d.shape = Sphere{-2}; }),
             Contains("Sphere.radius = -2") && Contains("> 0"));
  CHECK_THAT(refused([](ColliderDef& d) { d.friction = -0.1; }),
             Contains("friction = -0.1") && Contains(">= 0"));
  CHECK_THAT(refused([](ColliderDef& d) { d.restitution = 1.5; }),
             Contains("restitution = 1.5") && Contains("0 to 1"));
  CHECK_THAT(refused([](ColliderDef& d) { d.local.position.y() = NAN; }),
             Contains("local.position = nan"));
  CHECK_THAT(refused([](ColliderDef& d) { d.local.orientation.w() = 2; }),
             Contains("local.orientation = 2"));
  CHECK(f.scene.slot_count() == 0);

  CollisionOptions options;
  options.recycle_angle = 1.0;
  CHECK_THROWS_WITH(CollisionScene(options),
                    Contains("recycle_angle = 1") && Contains("0 to 0.2"));
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
  def.friction = 0.2;
  def.restitution = 0.1;
  f.scene.add(f.world, def);
  def.body = f.body(at(0.9, 0, 0));
  def.friction = 0.8;
  def.restitution = 0.6;
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
  def.category = 2;
  def.mask = 2;
  f.scene.add(f.world, def);  // sees only category 2
  CHECK(f.collect().empty());
  def.body = f.body(at(0, 1.2, 0), BodyType::Static);
  def.mask = 1 | 2;
  f.scene.add(f.world, def);
  def.body = f.body(at(0, 1.3, 0), BodyType::Kinematic);
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

TEST_CASE("contact_source: equal scenes give equal bytes, step after step", "[collision][golden]") {
  Fixture a, b;
  fill(a, flat_mesh(20.0, 19), 24, 8);
  fill(b, flat_mesh(20.0, 19), 24, 8);
  Solver solver_a, solver_b;
  for (int step = 0; step < 120; ++step) {
    a.collect();
    b.collect();
    REQUIRE(bytes_of(a.manifolds) == bytes_of(b.manifolds));
    solver_a.step(a.world, kDt);
    solver_b.step(b.world, kDt);
    REQUIRE(a.world.hash() == b.world.hash());
  }
}

TEST_CASE("contact_source: contacts do not depend on the order in which colliders were added",
          "[collision][golden]") {
  Random random(31);
  std::vector<std::pair<Shape, Pose>> bodies;
  bodies.emplace_back(HalfSpace{}, Pose{});
  for (int i = 0; i < 40; ++i) {
    const Shape shape = i % 3 == 0   ? Shape(Sphere{0.2})
                        : i % 3 == 1 ? Shape(Box{Vec3(0.2, 0.25, 0.15)})
                                     : Shape(Capsule{0.15, 0.2});
    bodies.emplace_back(shape, Pose{random.vec(0.6) + Vec3(0, 0, 0.6), random.quat()});
  }
  Fixture forward, backward;
  const auto build = [&](Fixture& f, bool reverse) {
    std::vector<BodyId> ids;
    for (const auto& [shape, pose] : bodies) {
      ids.push_back(f.body(pose, shape.index() == 3 ? BodyType::Static : BodyType::Dynamic));
    }
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const std::size_t i = reverse ? bodies.size() - 1 - k : k;
      ColliderDef def;
      def.body = ids[i];
      def.shape = bodies[i].first;
      f.scene.add(f.world, def);
    }
    f.collect();
    // Bring all into one order: lower body first.
    for (Manifold& m : f.manifolds) {
      m.key = 0;
      if (m.body_a < m.body_b) continue;
      std::swap(m.body_a, m.body_b);
      std::swap(m.radius_a, m.radius_b);
      m.normal = -m.normal;
      for (auto& p : m.points) std::swap(p.anchor_a_l, p.anchor_b_l);
    }
    std::sort(f.manifolds.begin(), f.manifolds.end(), [](const Manifold& l, const Manifold& r) {
      return std::pair(l.body_a, l.body_b) < std::pair(r.body_a, r.body_b);
    });
  };
  build(forward, false);
  build(backward, true);
  CHECK(forward.manifolds.size() > 50);
  CHECK(bytes_of(forward.manifolds) == bytes_of(backward.manifolds));
}

TEST_CASE("contact_source: resting stacks are neither asked about again nor do they allocate",
          "[collision][unit]") {
  for (const bool on_mesh : {false, true}) {
    Fixture f;
    f.fixed(on_mesh ? Shape(flat_mesh(20.0, 23)) : Shape(HalfSpace{}));
    std::vector<BodyId> boxes;
    for (int stack = 0; stack < 3; ++stack) {
      for (int i = 0; i < 5; ++i) {
        boxes.push_back(f.add(Box{Vec3::Constant(0.2)}, at(0.43 * stack, 0, 0.2 + 0.4 * i)));
      }
    }
    f.world.set_contact_source(&f.scene);
    Solver solver;
    for (int step = 0; step < 120; ++step) solver.step(f.world, kDt);
    std::vector<Vec3> before;
    for (const BodyId id : boxes) before.push_back(f.world.pose(id).position);
    std::size_t queries = 0;
    AllocationCount allocations;
    for (int step = 0; step < 120; ++step) {
      solver.step(f.world, kDt);
      queries += f.scene.stats().queries;
    }
    INFO((on_mesh ? "on a mesh" : "on a half-space"));
    CHECK(allocations.count() == 0);
    CHECK(queries == 0);
    CHECK(f.scene.stats().recycled == f.scene.stats().pairs);
    CHECK(f.scene.stats().manifolds >= 15);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      CHECK((f.world.pose(boxes[i]).position - before[i]).norm() < 1e-5);
    }
  }
}

TEST_CASE("contact_source: recycled contacts have the gaps of the poses as they are",
          "[collision][analytic]") {
  Fixture f;
  f.fixed(HalfSpace{});
  const BodyId box = f.add(Box{Vec3::Constant(0.5)}, at(0, 0, 0.5));
  f.collect();
  CHECK(f.scene.stats().queries == 1);
  const Vec3 turn(0.002, 0.001, 0.0);
  f.world.set_pose(box, at(Vec3(0.001, 0, 0.501), turn));
  f.collect();
  CHECK(f.scene.stats().queries == 0);
  CHECK(f.scene.stats().recycled == 1);
  REQUIRE(f.manifolds.size() == 1);
  const Manifold& m = f.manifolds[0];
  REQUIRE(m.count == 4);
  for (int i = 0; i < 4; ++i) CHECK(f.gap(m, i) == Approx(f.on_b(m, i).z()).margin(1e-12));
  f.world.set_pose(box, at(0.006, 0, 0.501));  // further than 5 mm
  f.collect();
  CHECK(f.scene.stats().queries == 1);
  f.world.set_pose(box, at(Vec3(0.006, 0, 0.501), Vec3(0, 0, 0.04)));  // turned by more than 2 deg
  f.collect();
  CHECK(f.scene.stats().queries == 1);
}

TEST_CASE("contact_source: a ball that rolls is looked at only as its centre moves on",
          "[collision][unit]") {
  Fixture f;
  f.fixed(Box{Vec3(5, 5, 0.5)}, at(0, 0, -0.5));
  const BodyId ball = f.add(Sphere{0.5}, at(0, 0, 0.5));
  f.collect();
  for (int k = 1; k <= 10; ++k) {
    f.world.set_pose(ball, at(Vec3(0, 0, 0.5), Vec3(0.2 * k, 0, 0)));
    f.collect();
    CHECK(f.scene.stats().queries == 0);
    REQUIRE(f.manifolds.size() == 1);
    CHECK(f.gap(f.manifolds[0], 0) == Approx(0.0).margin(1e-12));
  }
}

TEST_CASE("contact_source: a restored world goes on with the same bits", "[collision][golden]") {
  for (const Shape& ground : {Shape(HalfSpace{}), Shape(flat_mesh(20.0, 19))}) {
    Fixture original, other;
    fill(original, ground, 24, 17);
    fill(other, ground, 24, 17);
    Solver solver;
    for (int step = 0; step < 70; ++step) solver.step(original.world, kDt);
    const std::vector<std::byte> snapshot = original.world.snapshot();
    // Into the same world later on, and into one that has never run.
    std::vector<std::uint64_t> hashes;
    for (int step = 0; step < 100; ++step) {
      solver.step(original.world, kDt);
      hashes.push_back(original.world.hash());
    }
    for (Fixture* f : {&original, &other}) {
      f->world.restore(snapshot);
      CHECK(f->world.snapshot() == snapshot);
      for (int step = 0; step < 100; ++step) {
        solver.step(f->world, kDt);
        REQUIRE(f->world.hash() == hashes[step]);
      }
    }
  }
}

TEST_CASE("contact_source: bytes that are no snapshot of the scene are refused",
          "[collision][fault]") {
  Fixture f;
  fill(f, HalfSpace{}, 12, 3);
  Solver solver;
  for (int step = 0; step < 40; ++step) solver.step(f.world, kDt);
  std::vector<std::byte> good;
  ByteWriter writer(good);
  f.scene.save(writer);
  const auto load = [&](std::span<const std::byte> bytes) {
    ByteReader in(bytes);
    f.scene.load(in);
    return !in.failed();
  };
  CHECK(load(good));
  for (std::size_t cut = 0; cut < good.size(); cut += 37) {
    CHECK_FALSE(load(std::span(good).first(cut)));
  }
  Random random(1);
  for (int k = 0; k < 2000; ++k) {  // anything goes but a crash or a hang
    std::vector<std::byte> bad = good;
    for (int n = 0; n < 3; ++n) {
      bad[static_cast<std::size_t>(random.in(0, double(bad.size())))] =
          static_cast<std::byte>(random.in(0, 256));
    }
    load(bad);
    f.collect();
  }
  CHECK(load(good));
  Fixture smaller;
  fill(smaller, HalfSpace{}, 11, 3);
  ByteReader in(good);
  smaller.scene.load(in);
  CHECK(in.failed());
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
  f.world.set_pose(floor, at(Vec3::Zero(), Vec3(0, M_PI / 2, 0)));  // now a wall facing +x
  REQUIRE(f.collect().size() == 1);
  CHECK((f.manifolds[0].normal + Vec3::UnitX()).norm() < 1e-9);
}

TEST_CASE("contact_source: parts of a body are placed by their local poses", "[collision][unit]") {
  Fixture f;
  f.fixed(HalfSpace{});
  ColliderDef def;
  def.body = f.body(at(Vec3(1, 2, 3), Vec3(0, 0, M_PI / 2)));
  def.shape = Sphere{0.5};
  def.local = at(1, 0, -2.51);
  f.scene.add(f.world, def);
  REQUIRE(f.collect().size() == 1);
  const Manifold& m = f.manifolds[0];
  CHECK((f.on_b(m, 0) - Vec3(1, 3, 0.49)).norm() < 1e-12);
  CHECK((m.points[0].anchor_b_l - Vec3(1, 0, -2.51)).norm() < 1e-12);
  CHECK(f.gap(m, 0) == Approx(-0.01));
}
