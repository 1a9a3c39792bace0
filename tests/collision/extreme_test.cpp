// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Fast, small, large and far away.
#include <algorithm>

#include "allocation_count.h"
#include "scenes.h"
#include "tandem/collision/compound.h"
#include "tandem/pbd/solver.h"

namespace extreme_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::pbd::Solver;

namespace {

/// A wall at x = 0 that faces -x, bumpy where asked.
Mesh wall_mesh(double depth) {
  constexpr std::uint32_t kSide = 12;
  Random random(3);
  std::vector<Vec3> v;
  std::vector<TriangleMesh::Triangle> t;
  for (std::uint32_t j = 0; j <= kSide; ++j) {
    for (std::uint32_t i = 0; i <= kSide; ++i) {
      v.emplace_back(random.in(-depth, 0.0), -20.0 + 40.0 * i / kSide, -20.0 + 40.0 * j / kSide);
    }
  }
  for (std::uint32_t j = 0; j < kSide; ++j) {
    for (std::uint32_t i = 0; i < kSide; ++i) {
      const std::uint32_t a = j * (kSide + 1) + i;
      t.push_back({a, a + kSide + 2, a + 1});
      t.push_back({a, a + kSide + 1, a + kSide + 2});
    }
  }
  return TriangleMesh::make(v, t);
}

}  // namespace

TEST_CASE("extreme: at 1000 m/s nothing gets through a wall of 1 cm or a mesh",
          "[collision][soak]") {
  const std::vector<Shape> walls{Box{Vec3(0.005, 20, 20)}, wall_mesh(0.0), wall_mesh(0.6)};
  Random random(5);
  for (std::size_t wall = 0; wall < walls.size(); ++wall) {
    for (const Shape& shape : convex_shapes(0.1)) {
      for (const double dt : {0.001, 1.0 / 60.0, 0.1}) {
        for (const double speed : {60.0, 1000.0}) {
          Fixture f;
          f.world.set_gravity(Vec3::Zero());
          f.fixed(walls[wall]);
          const double distance = random.in(1.2, 8.0);
          const BodyId id = f.add(shape, {Vec3(-distance, 0.1, 0.2), random.quat()});
          const double y = random.in(-0.5, 0.5);
          const Vec3 direction = Vec3(1, y, random.in(-0.5, 0.5)).normalized();
          f.world.set_twist(id, {speed * direction, random.vec(20.0)});
          f.world.set_contact_source(&f.scene);
          Solver solver;
          INFO("wall " << wall << " shape " << shape.index() << " step " << dt << " speed "
                       << speed);
          for (int step = 0; step < 15 + static_cast<int>(0.1 / dt / 5); ++step) {
            (void)solver.step(f.world, dt);
            const Vec3 p = f.world.pose(id).position;
            if (std::abs(p.y()) > 19 || std::abs(p.z()) > 19) break;  // past its border
            REQUIRE(p.x() <= 1e-9);
          }
        }
      }
    }
  }
}

TEST_CASE("extreme: a motion that stays on its side is not limited", "[collision][unit]") {
  Fixture f;
  f.fixed(Box{Vec3(0.005, 2, 2)});
  const BodyId ball = f.add(Sphere{0.1}, at(-3, 0, 0));
  f.collect();
  std::vector<Pose> after{f.world.pose(f.world.body_at(0)), f.world.pose(ball)};
  std::vector<tandem::pbd::MotionLimit> limits;
  const auto ask = [&](const Vec3& to) {
    after[1].position = to;
    f.scene.limit_motion(f.world, after, f.workers, limits);
    return limits.size();
  };
  CHECK(ask(Vec3(-0.5, 1, 1)) == 0);
  CHECK(ask(Vec3(3, 0, 4.2)) == 0);  // passes 5 cm above the wall's upper side
  REQUIRE(ask(Vec3(3, 0, 0)) == 1);
  // The core has a quarter of the least extent as radius: it stops 5 cm before the wall.
  CHECK(limits[0].share == Approx((3 - 0.005 - 0.05) / 6.0).margin(1e-4));
  CHECK((limits[0].normal + Vec3::UnitX()).norm() < 1e-9);
}

TEST_CASE("extreme: two bullets that meet head on do not swap places", "[collision][unit]") {
  for (const double dt : {0.001, 1.0 / 60.0, 0.1}) {
    Fixture f;
    f.world.set_gravity(Vec3::Zero());
    std::array<BodyId, 2> ids;
    for (int i = 0; i < 2; ++i) {
      ids[i] = f.world.add_body({.pose = at(i == 0 ? -4.0 : 4.0, 0, 0), .bullet = true});
      f.scene.add(f.world, {.body = ids[i], .shape = Sphere{0.05}});
      f.world.set_twist(ids[i], {Vec3(i == 0 ? 1000.0 : -1000.0, 0, 0), Vec3::Zero()});
    }
    f.world.set_contact_source(&f.scene);
    Solver solver;
    for (int step = 0; step < 20; ++step) {
      (void)solver.step(f.world, dt);
      INFO("step " << dt);
      CHECK(f.world.pose(ids[0]).position.x() < f.world.pose(ids[1]).position.x());
    }
  }
}

TEST_CASE("extreme: contacts do not depend on where in the world they are",
          "[collision][analytic]") {
  const std::vector<Shape> shapes = convex_shapes(1.0);
  const Mesh ground = box_mesh(Vec3(3, 3, 0.5));
  Random random(12);
  const Vec3 far(1e5, -0.75e5, 0.5e5);  // exactly a sum with the poses below to 1.5e-11 m
  int compared = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = 0; j <= shapes.size(); ++j) {
      for (int k = 0; k < 12; ++k) {
        const bool on_mesh = j == shapes.size();
        const Shape& other = on_mesh ? Shape(ground) : shapes[j];
        // Positions that both places can hold without rounding.
        const auto round = [](const Vec3& v) {
          return Vec3((v * 1024.0).array().round() / 1024.0);
        };
        const Pose a{round(random.vec(0.2)), random.quat()};
        const Pose b{round(random.vec(0.2) + Vec3(0, 0, on_mesh ? -1.1 : -0.8)),
                     on_mesh ? Quat(Quat::Identity()) : random.quat()};
        Fixture near, away;
        for (Fixture* f : {&near, &away}) {
          const Vec3 shift = f == &near ? Vec3(Vec3::Zero()) : far;
          f->add(shapes[i], {a.position + shift, a.orientation});
          f->fixed(other, {b.position + shift, b.orientation});
          f->collect();
        }
        INFO("kinds " << i << " " << j << " case " << k);
        REQUIRE(near.manifolds.size() == away.manifolds.size());
        for (std::size_t m = 0; m < near.manifolds.size(); ++m) {
          const Manifold& p = near.manifolds[m];
          const Manifold& q = away.manifolds[m];
          ++compared;
          CHECK((p.normal - q.normal).norm() < 1e-9);
          REQUIRE(p.count == q.count);
          for (int n = 0; n < p.count; ++n) {
            CHECK((p.points[n].anchor_a_l - q.points[n].anchor_a_l).norm() < 1e-9);
            CHECK((p.points[n].anchor_b_l - q.points[n].anchor_b_l).norm() < 1e-9);
          }
        }
      }
    }
  }
  CHECK(compared > 250);
}

TEST_CASE("extreme: contacts of a millimetre are those of a metre, smaller",
          "[collision][analytic]") {
  // Options that scale with size, so that only tolerances could differ.
  Random random(21);
  int compared = 0;
  for (const double scale : {1e-3, 100.0}) {
    const std::vector<Shape> one = convex_shapes(1.0);
    const std::vector<Shape> other = convex_shapes(scale);
    for (std::size_t i = 0; i < one.size(); ++i) {
      for (std::size_t j = 0; j < one.size(); ++j) {
        for (int k = 0; k < 12; ++k) {
          const Pose a{random.vec(0.2), random.quat()};
          const Pose b{random.vec(0.2) + Vec3(0, 0, -0.8), random.quat()};
          Fixture f, g;
          f.add(one[i], a);
          f.fixed(one[j], b);
          g.add(other[i], {scale * a.position, a.orientation});
          g.fixed(other[j], {scale * b.position, b.orientation});
          f.collect();
          g.collect();
          const double gap_f = f.manifolds.empty() ? 1.0 : f.deepest(f.manifolds[0]);
          const double gap_g = g.manifolds.empty() ? 1.0 : g.deepest(g.manifolds[0]) / scale;
          INFO("scale " << scale << " kinds " << i << " " << j << " case " << k << " gap "
                        << gap_f);
          if (gap_f > -1e-3) continue;  // the margins are not the same
          ++compared;
          REQUIRE(!g.manifolds.empty());
          // Around round sides the depth is flat: half as many digits of the direction.
          CHECK((f.manifolds[0].normal - g.manifolds[0].normal).norm() < 1e-2);
          CHECK(gap_g == Approx(gap_f).margin(1e-4));
        }
      }
    }
  }
  CHECK(compared > 200);
}

TEST_CASE("extreme: a millimetre and a hundred metres rest in one scene", "[collision][soak]") {
  Fixture f;
  f.fixed(Box{Vec3(200, 200, 100)}, at(0, 0, -100));
  f.world.set_contact_source(&f.scene);
  std::vector<BodyId> ids;
  const auto add = [&](const Shape& shape, const Pose& pose) {
    const MassProperties mass = mass_properties(shape, 1000.0);
    const BodyId id = f.world.add_body({.pose = pose, .mass = mass.mass, .inertia = mass.inertia});
    f.scene.add(f.world, {.body = id, .shape = shape});
    ids.push_back(id);
  };
  add(Box{Vec3::Constant(50)}, at(0, 0, 50));
  add(Box{Vec3::Constant(5e-4)}, at(60, 0, 5e-4));
  add(Box{Vec3::Constant(5e-4)}, at(60, 0, 15e-4));
  add(Cylinder{5e-4, 5e-4}, at(61, 0, 5e-4));
  add(Box{Vec3::Constant(5e-4)}, at(0, 0, 100 + 5e-4));
  std::vector<Vec3> before;
  for (const BodyId id : ids) before.push_back(f.world.pose(id).position);
  Solver solver;
  for (int step = 0; step < 120; ++step) (void)solver.step(f.world, kDt);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    INFO("body " << i);
    CHECK((f.world.pose(ids[i]).position - before[i]).norm() < (i == 0 ? 1e-3 : 1e-4));
  }
}

TEST_CASE("extreme: contacts that are asked for again allocate nothing", "[collision][unit]") {
  // Everything moves a little, further than what recycling allows, and keeps its contacts.
  Fixture f;
  CollisionOptions options;
  options.recycle_distance = 0.0;
  f.scene = CollisionScene(options);
  f.fixed(flat_mesh(20.0, 19));
  std::vector<BodyId> ids;
  const std::vector<Shape> shapes = convex_shapes(0.5);
  for (int i = 0; i < 36; ++i) {
    ids.push_back(f.add(shapes[static_cast<std::size_t>(i) % shapes.size()],
                        at(0.45 * (i % 6), 0.45 * (i / 6), 0.24)));
  }
  const auto shake = [&](int step) {
    for (const BodyId id : ids) {
      Pose pose = f.world.pose(id);
      pose.position.x() += step % 2 == 0 ? 1e-4 : -1e-4;
      f.world.set_pose(id, pose);
    }
    f.collect();
  };
  for (int step = 0; step < 20; ++step) shake(step);
  AllocationCount allocations;
  for (int step = 0; step < 20; ++step) shake(step);
  const auto count = allocations.count();
  CHECK(f.manifolds.size() > 40);
  CHECK(f.scene.stats().queries > 40);
  CHECK(count == 0);
}

}  // namespace extreme_test
