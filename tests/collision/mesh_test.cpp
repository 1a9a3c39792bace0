// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <numbers>

#include "fixture.h"
#include "tandem/pbd/solver.h"

namespace mesh_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::pbd::exp_map;

namespace {

CollisionOptions without_recycling() {
  CollisionOptions options;
  options.recycle_distance = 0.0;
  return options;
}

/// A roof or a valley along y: heights slope |x| with the given slope (negative: roof).
Mesh fold(double slope, int cells) {
  std::vector<Vec3> v;
  std::vector<TriangleMesh::Triangle> t;
  for (int j = 0; j <= cells; ++j) {
    const double y = -3.0 + 6.0 * j / cells;
    for (const double x : {-3.0, 0.0, 3.0}) v.emplace_back(x, y, slope * std::abs(x));
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < 2; ++i) {
      const auto a = static_cast<std::uint32_t>(3 * j + i);
      t.push_back({a, a + 1, a + 4});
      t.push_back({a, a + 4, a + 3});
    }
  }
  return TriangleMesh::make(v, t);
}

struct Slide {
  Shape shape;
  double height;  // of the centre when it just touches
  int points;
  Vec3 turn;
};

const std::vector<Slide>& slides() {
  static const std::vector<Slide> kSlides{
      {Sphere{0.3}, 0.3, 1, Vec3::Zero()},
      {Box{Vec3(0.4, 0.3, 0.2)}, 0.2, 4, Vec3::Zero()},
      {Capsule{0.2, 0.5}, 0.2, 2, Vec3(0, std::numbers::pi / 2, 0)}};
  return kSlides;
}

}  // namespace

TEST_CASE("mesh: a flat mesh carries like the half-space under it, wherever a body slides",
          "[collision][analytic]") {
  for (const Slide& slide : slides()) {
    for (const double gap : {-2e-3, -1e-5, 1e-4, 5e-3}) {
      for (const double speed : {0.0, 3.0}) {
        Fixture mesh(without_recycling());
        Fixture plane(without_recycling());
        mesh.fixed(flat_mesh(8.0, 13));
        plane.fixed(HalfSpace{});
        const BodyId a = mesh.add(slide.shape);
        const BodyId b = plane.add(slide.shape);
        for (int k = 0; k < 60; ++k) {
          const double yaw = 0.07 * k;
          const Pose pose{Vec3(-1.9 + 0.063 * k, -1.3 + 0.041 * k, slide.height + gap),
                          exp_map(Vec3(0, 0, yaw)) * exp_map(slide.turn)};
          for (Fixture* f : {&mesh, &plane}) {
            const BodyId id = f == &mesh ? a : b;
            f->world.set_pose(id, pose);
            f->world.set_twist(id, {Vec3(speed, 0.5 * speed, 0), Vec3::Zero()});
            f->collect();
          }
          INFO("shape " << slide.shape.index() << " gap " << gap << " speed " << speed << " step "
                        << k);
          REQUIRE(mesh.manifolds.size() == 1);
          REQUIRE(plane.manifolds.size() == 1);
          const Manifold& m = mesh.manifolds[0];
          const Manifold& p = plane.manifolds[0];
          CHECK((m.normal - Vec3::UnitZ()).norm() < 1e-9);
          CHECK((p.normal - Vec3::UnitZ()).norm() < 1e-9);
          REQUIRE(m.count == slide.points);
          REQUIRE(p.count == slide.points);
          CHECK(m.key == mesh.manifolds[0].key);
          for (int i = 0; i < m.count; ++i) {
            CHECK(mesh.gap(m, i) == Approx(gap).margin(1e-9));
            double nearest = HUGE_VAL;
            for (int j = 0; j < p.count; ++j) {
              nearest = std::min(nearest, (m.points[i].anchor_b_l - p.points[j].anchor_b_l).norm());
            }
            CHECK(nearest < 1e-6);
          }
        }
      }
    }
  }
}

TEST_CASE("mesh: a tilted box on a flat mesh is never pushed sideways", "[collision][unit]") {
  Random random(9);
  for (int k = 0; k < 2000; ++k) {
    Fixture f(without_recycling());
    f.fixed(flat_mesh(8.0, 13));
    const Vec3 half(0.4, 0.3, 0.2);
    const double yaw = random.in(-3, 3);
    const Pose tilt{Vec3::Zero(), exp_map(Vec3(0, 0, yaw)) * exp_map(random.vec(0.3))};
    const double reach = (tilt.orientation.toRotationMatrix().cwiseAbs() * half).z();
    const double depth = random.in(0.0, 5e-3);
    const double x = random.in(-1, 1);
    f.add(Box{half}, {Vec3(x, random.in(-1, 1), reach - depth), tilt.orientation});
    f.collect();
    INFO("case " << k << " depth " << depth);
    REQUIRE(f.manifolds.size() == 1);
    CHECK((f.manifolds[0].normal - Vec3::UnitZ()).norm() < 1e-9);
    CHECK(f.deepest(f.manifolds[0]) == Approx(-depth).margin(1e-9));
  }
}

TEST_CASE("mesh: a ball on the mesh of a box feels the box", "[collision][analytic]") {
  const Vec3 half(0.5, 0.6, 0.7);
  Random random(21);
  int compared = 0;
  for (int k = 0; k < 3000; ++k) {
    const Vec3 p = random.vec(1.1);
    const Vec3 nearest = p.cwiseMax(-half).cwiseMin(half);
    const double distance = (p - nearest).norm();
    if (distance < 1e-3) continue;  // the centre is inside: only fronts touch
    Fixture f;
    f.fixed(box_mesh(half));
    f.add(Sphere{0.3}, {p, Quat::Identity()});
    f.collect();
    INFO("case " << k << " at " << p.transpose());
    if (distance > 0.32) {
      CHECK(f.manifolds.empty());
      continue;
    }
    REQUIRE(f.manifolds.size() >= 1);
    double least = HUGE_VAL;
    const Manifold* best = nullptr;
    for (const Manifold& m : f.manifolds) {
      if (f.deepest(m) < least) {
        least = f.deepest(m);
        best = &m;
      }
      // Never a normal that the box would not have: none beyond the nearest feature's.
      CHECK(f.deepest(m) >= distance - 0.3 - 1e-9);
    }
    CHECK(least == Approx(distance - 0.3).margin(1e-9));
    CHECK((best->normal - (p - nearest) / distance).norm() < 1e-6);
    CHECK(f.manifolds.size() == 1);
    ++compared;
  }
  CHECK(compared > 500);
}

TEST_CASE("mesh: boxes and capsules on the mesh of a box are as deep as on the box",
          "[collision][analytic]") {
  const Vec3 half(0.8, 0.9, 1.0);
  Random random(22);
  int compared = 0;
  for (const Shape& shape : {Shape(Box{Vec3(0.3, 0.2, 0.25)}), Shape(Capsule{0.2, 0.3})}) {
    for (int k = 0; k < 1500; ++k) {
      const Pose pose{random.vec(1.4), random.quat()};
      Fixture mesh, box;
      mesh.fixed(box_mesh(half));
      mesh.add(shape, pose);
      box.fixed(Box{half});
      box.add(shape, pose);
      mesh.collect();
      box.collect();
      INFO("kind " << shape.index() << " case " << k);
      double on_mesh = HUGE_VAL;
      for (const Manifold& m : mesh.manifolds) on_mesh = std::min(on_mesh, mesh.deepest(m));
      double on_box = HUGE_VAL;
      for (const Manifold& m : box.manifolds) on_box = std::min(on_box, box.deepest(m));
      // Shallow overlap: a corner deep behind two sides is held by both of them.
      if (on_box < 0.0 && on_box > -0.03) {
        REQUIRE(!mesh.manifolds.empty());
        CHECK(on_mesh <= 0.9 * on_box + 2e-3);
        CHECK(on_mesh >= 1.2 * on_box - 2e-3);
        ++compared;
      }
      // Far apart on the box means far apart on its mesh.
      if (on_box > 0.02) CHECK(on_mesh > -1e-3);
    }
  }
  CHECK(compared > 100);
}

TEST_CASE("mesh: only fronts touch", "[collision][unit]") {
  for (const Slide& slide : slides()) {
    Fixture f;
    f.fixed(flat_mesh(4.0, 3));
    f.add(slide.shape, at(Vec3(0.1, 0.1, -slide.height + 0.001), slide.turn));
    CHECK(f.collect().empty());
  }
}

TEST_CASE("mesh: a ball that is pushed through in one step is pushed back", "[collision][unit]") {
  Fixture f(without_recycling());
  f.fixed(flat_mesh(4.0, 3));
  const BodyId ball = f.add(Sphere{0.3}, at(0.1, 0.1, 0.29));
  REQUIRE(f.collect().size() == 1);
  f.world.set_pose(ball, at(0.1, 0.1, -0.05));  // the centre is behind now
  REQUIRE(f.collect().size() == 1);
  CHECK((f.manifolds[0].normal - Vec3::UnitZ()).norm() < 1e-9);
  CHECK(f.gap(f.manifolds[0], 0) == Approx(-0.35).margin(1e-9));
}

TEST_CASE("mesh: on a ridge normals stay between those of its two sides", "[collision][unit]") {
  const double slope = -0.5;
  const Vec3 left = Vec3(slope, 0, 1).normalized();  // normal of the side x < 0
  const Vec3 right = Vec3(-slope, 0, 1).normalized();
  const double spread = left.dot(right);
  for (const Slide& slide : slides()) {
    for (int k = 0; k <= 200; ++k) {
      Fixture f(without_recycling());
      f.fixed(fold(slope, 7));
      const double x = -0.5 + 0.005 * k;
      // The middle of the shape right above the surface, level.
      f.add(slide.shape, at(Vec3(x, 0.05, slope * std::abs(x) + slide.height + 0.01), slide.turn));
      f.collect();
      for (const Manifold& m : f.manifolds) {
        INFO("kind " << slide.shape.index() << " x " << x << " normal " << m.normal.transpose());
        CHECK(m.normal.dot(left) >= spread - 1e-6);
        CHECK(m.normal.dot(right) >= spread - 1e-6);
        CHECK(std::abs(m.normal.y()) < 1e-6);
      }
      if (std::abs(x) < 0.05) CHECK(!f.manifolds.empty());
    }
  }
}

TEST_CASE("mesh: in a valley a ball rests on both sides", "[collision][analytic]") {
  Fixture f;
  f.fixed(fold(0.5, 7));
  const double r = 0.3;
  // Touching both sides: height of the centre = r / cos(slope angle).
  f.add(Sphere{r}, at(0, 0.05, r * std::sqrt(1.25) - 0.001));
  f.collect();
  REQUIRE(f.manifolds.size() == 2);
  for (const Manifold& m : f.manifolds) {
    CHECK(std::abs(m.normal.x()) == Approx(0.5 / std::sqrt(1.25)));
    CHECK(m.normal.z() == Approx(1.0 / std::sqrt(1.25)));
    CHECK(f.gap(m, 0) == Approx(-0.001 / std::sqrt(1.25)).margin(1e-9));
  }
  CHECK(f.manifolds[0].normal.x() * f.manifolds[1].normal.x() < 0.0);
  CHECK(f.manifolds[0].key != f.manifolds[1].key);
}

TEST_CASE("mesh: clusters keep their keys while a ball moves along a valley", "[collision][unit]") {
  Fixture f(without_recycling());
  f.fixed(fold(0.5, 7));
  const double z = 0.3 * std::sqrt(1.25) - 0.001;
  const BodyId ball = f.add(Sphere{0.3}, at(0, -2.0, z));
  f.collect();
  REQUIRE(f.manifolds.size() == 2);
  std::vector<Manifold> first = f.manifolds;
  for (int k = 1; k < 400; ++k) {
    f.world.set_pose(ball, at(0, -2.0 + 0.01 * k, z));
    f.collect();
    REQUIRE(f.manifolds.size() == 2);
    for (int i = 0; i < 2; ++i) {
      CHECK(f.manifolds[i].key == first[i].key);
      CHECK((f.manifolds[i].normal - first[i].normal).norm() < 1e-9);
    }
  }
}

TEST_CASE("mesh: bodies slide and roll over a flat mesh as over a half-space",
          "[collision][analytic]") {
  for (const Slide& slide : slides()) {
    double end[2] = {0, 0};
    double highest[2] = {0, 0};
    for (int ground = 0; ground < 2; ++ground) {
      Fixture f;
      f.fixed(ground == 0 ? Shape(HalfSpace{}) : Shape(flat_mesh(30.0, 41)));
      const MassProperties mass = mass_properties(slide.shape, 1000.0);
      tandem::pbd::BodyDef def;
      def.mass = mass.mass;
      def.inertia = mass.inertia;
      def.pose = at(Vec3(-3, 0.1, slide.height), slide.turn);
      def.twist.linear = Vec3(4, 0.7, 0);
      const BodyId id = f.world.add_body(def);
      ColliderDef collider;
      collider.body = id;
      collider.shape = slide.shape;
      collider.material.friction = 0.3;
      f.scene.add(f.world, collider);
      f.world.set_contact_source(&f.scene);
      tandem::pbd::Solver solver;
      for (int k = 0; k < 90; ++k) {
        solver.step(f.world, kDt);
        highest[ground] = std::max(highest[ground], f.world.pose(id).position.z() - slide.height);
      }
      end[ground] = f.world.pose(id).position.x();
    }
    INFO("kind " << slide.shape.index());
    CHECK(end[1] == Approx(end[0]).margin(0.01));
    CHECK(highest[0] < 1e-3);
    CHECK(highest[1] < 1e-3);
  }
}

}  // namespace mesh_test
