// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>

#include "allocation_count.h"
#include "scenes.h"
#include "tandem/pbd/solver.h"

namespace determinism_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::pbd::ByteReader;
using tandem::pbd::ByteWriter;
using tandem::pbd::Quat;
using tandem::pbd::Solver;

TEST_CASE("determinism: equal scenes give equal bytes, step after step", "[collision][golden]") {
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

TEST_CASE("determinism: rows solved two or four at a time move bodies by the same bits",
          "[collision][golden]") {
  // Balls and faces, bounces, heavy bodies on light ones, levels that fill no block.
  const auto build = [](Fixture& f) {
    fill(f, flat_mesh(20.0, 19), 48, 8);
    Random random(5);
    for (int i = 0; i < 20; ++i) {
      const double mass = i % 4 == 0 ? 500.0 : 5.0;
      const BodyId body = f.world.add_body(
          {.pose = {random.vec(0.5) + Vec3(0.0, 0.0, 4.0 + 0.4 * i), Quat::Identity()},
           .mass = mass,
           .inertia = 0.01 * mass * tandem::pbd::Mat3::Identity()});
      f.scene.add(f.world,
                  {.body = body,
                   .shape = i % 2 == 0 ? Shape(Box{Vec3(0.2, 0.15, 0.1)}) : Shape(Sphere{0.15}),
                   .material = {.friction = 0.1 * (i % 5), .restitution = 0.2 * (i % 3)}});
    }
  };
  Fixture two, four;
  build(two);
  build(four);
  Solver solver_two({.contact = {.lanes = 2}});
  Solver solver_four({.contact = {.lanes = 4}});
  for (int step = 0; step < 180; ++step) {
    solver_two.step(two.world, kDt);
    solver_four.step(four.world, kDt);
    REQUIRE(two.world.hash() == four.world.hash());
  }
}

TEST_CASE("determinism: contacts do not depend on the order in which colliders were added",
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

TEST_CASE("recycling: resting stacks are neither asked about again nor do they allocate",
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

TEST_CASE("recycling: recycled contacts have the gaps of the poses as they are",
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

TEST_CASE("recycling: a ball that rolls is looked at only as its centre moves on",
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

TEST_CASE("determinism: a restored world goes on with the same bits", "[collision][golden]") {
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

namespace {

/// Boxes and a ball on a mesh, run until all sleep.
struct Sleepers {
  Fixture f;
  std::vector<BodyId> bodies;
  Solver solver;

  Sleepers() {
    f.fixed(flat_mesh(20.0, 23));
    for (int i = 0; i < 3; ++i)
      bodies.push_back(f.add(Box{Vec3::Constant(0.2)}, at(0, 0, 0.2 + 0.4 * i)));
    bodies.push_back(f.add(Sphere{0.2}, at(2.05, 0.1, 0.2)));
    bodies.push_back(f.add(Box{Vec3::Constant(0.2)}, at(3, 0, 0.2)));
    f.world.set_contact_source(&f.scene);
    run();
  }
  /// @return whether all sleep
  bool run() {
    for (int step = 0; step < 240; ++step) solver.step(f.world, kDt);
    return std::none_of(bodies.begin(), bodies.end(), [&](BodyId id) { return f.world.awake(id); });
  }
  std::vector<std::uint64_t> keys() {
    std::vector<std::uint64_t> out;
    for (const Manifold& m : f.collect()) out.push_back(m.key);
    return out;
  }
};

}  // namespace

TEST_CASE("sleep: a sleeping body keeps its contacts without detection", "[collision][unit]") {
  Sleepers s;
  REQUIRE(s.run());
  const std::vector<std::byte> before = bytes_of(s.f.collect());
  CHECK(s.f.manifolds.size() == 5);
  AllocationCount allocations;
  std::size_t queries = 0;
  for (int step = 0; step < 30; ++step) {
    s.solver.step(s.f.world, kDt);
    queries += s.f.scene.stats().queries;
  }
  CHECK(allocations.count() == 0);
  CHECK(queries == 0);
  CHECK(bytes_of(s.f.collect()) == before);
}

TEST_CASE("sleep: a sleeping body that is moved is found where it is", "[collision][fault]") {
  Sleepers s;
  REQUIRE(s.run());
  // The top of the stack onto the box beside, the ball away from everything.
  s.f.world.set_pose(s.bodies[2], at(3, 0, 0.6));
  s.f.world.set_pose(s.bodies[3], at(2, 0, 5));
  Fixture fresh;
  fresh.fixed(flat_mesh(20.0, 23));
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    const Pose pose = s.f.world.pose(s.bodies[i]);
    if (i == 3) {
      fresh.add(Sphere{0.2}, pose);
    } else {
      fresh.add(Box{Vec3::Constant(0.2)}, pose);
    }
  }
  std::vector<std::uint64_t> expected;
  for (const Manifold& m : fresh.collect()) expected.push_back(m.key);
  CHECK(expected.size() == 4);
  CHECK(s.keys() == expected);
}

TEST_CASE("sleep: a snapshot of sleepers brings back their contacts", "[collision][golden]") {
  Sleepers s;
  REQUIRE(s.run());
  const std::vector<std::byte> snapshot = s.f.world.snapshot();
  const std::vector<std::byte> before = bytes_of(s.f.collect());
  s.f.world.set_pose(s.bodies[2], at(3, 0, 0.6));
  s.f.world.set_pose(s.bodies[3], at(1, 0, 0.2));
  REQUIRE(s.run());  // they sleep again, elsewhere
  CHECK(bytes_of(s.f.collect()) != before);
  s.f.world.restore(snapshot);
  CHECK(bytes_of(s.f.collect()) == before);
}

TEST_CASE("determinism: bytes that are no snapshot of the scene are refused",
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

}  // namespace determinism_test
