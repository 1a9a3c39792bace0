// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <numbers>

#include "fixture.h"

namespace manifold_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;

namespace {

/// Both in their usual order, and with the second one added first.
struct Both {
  Fixture forward;
  Fixture backward;
  Both(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
       BodyType type_b = BodyType::Static) {
    forward.add(a, pose_a);
    forward.add(b, pose_b, type_b);
    backward.add(b, pose_b, type_b);
    backward.add(a, pose_a);
    forward.collect();
    backward.collect();
  }
};

/// The only manifold, from the first shape to the second.
const Manifold& only(const Fixture& f) {
  REQUIRE(f.manifolds.size() == 1);
  return f.manifolds[0];
}

void check_vec(const Vec3& value, const Vec3& expected, double tolerance = 1e-12) {
  INFO("value " << value.transpose() << " expected " << expected.transpose());
  CHECK((value - expected).norm() <= tolerance);
}

}  // namespace

TEST_CASE("manifold: sphere on sphere", "[collision][analytic]") {
  Fixture f;
  f.add(Sphere{0.5}, at(1, 2, 3));
  f.add(Sphere{0.3}, at(1, 2, 3.79));
  f.collect();
  const Manifold& m = only(f);
  check_vec(m.normal, Vec3::UnitZ());
  CHECK(m.count == 1);
  CHECK(m.radius_a == 0.5);
  CHECK(m.radius_b == 0.3);
  CHECK(f.gap(m, 0) == Approx(-0.01).margin(1e-12));
  check_vec(f.on_a(m, 0), Vec3(1, 2, 3));
  check_vec(f.on_b(m, 0), Vec3(1, 2, 3.79));
}

TEST_CASE("manifold: sphere against the face, edge, corner and inside of a box",
          "[collision][analytic]") {
  const Box box{Vec3(1, 1, 1)};
  struct Case {
    Vec3 centre, normal, on_box;
    double gap;
  };
  const double r2 = std::sqrt(0.5);
  const double r3 = std::sqrt(1.0 / 3.0);
  const std::vector<Case> cases{
      {Vec3(0.3, -0.2, 1.49), Vec3(0, 0, -1), Vec3(0.3, -0.2, 1), -0.01},
      {Vec3(1 + 0.5 * r2, 0.1, 1 + 0.5 * r2), Vec3(-r2, 0, -r2), Vec3(1, 0.1, 1), 0.0},
      {Vec3(1, 1, 1) + 0.4 * r3 * Vec3::Ones(), -r3 * Vec3::Ones(), Vec3(1, 1, 1), -0.1},
      {Vec3(0.1, 0.9, 0.2), Vec3(0, -1, 0), Vec3(0.1, 1, 0.2), -0.6}};
  for (const Case& c : cases) {
    Fixture f;
    f.add(Sphere{0.5}, {c.centre, Quat::Identity()});
    f.fixed(box);
    f.collect();
    const Manifold& m = only(f);
    check_vec(m.normal, c.normal);
    check_vec(f.on_b(m, 0), c.on_box);
    CHECK(f.gap(m, 0) == Approx(c.gap).margin(1e-12));
    CHECK(m.radius_b == 0.0);
  }
}

TEST_CASE("manifold: a box on a plane stands on its four lower corners", "[collision][analytic]") {
  Fixture f;
  f.add(Box{Vec3(0.5, 0.4, 0.3)}, at(5, 6, 0.299));
  f.fixed(HalfSpace{});
  f.collect();
  const Manifold& m = only(f);
  check_vec(m.normal, -Vec3::UnitZ());
  REQUIRE(m.count == 4);
  double area = 0.0;
  for (int i = 0; i < 4; ++i) {
    CHECK(f.gap(m, i) == Approx(-0.001).margin(1e-12));
    CHECK(std::abs(f.on_a(m, i).x() - 5) == Approx(0.5));
    CHECK(std::abs(f.on_a(m, i).y() - 6) == Approx(0.4));
    area += (f.on_a(m, i).x() - 5) * (f.on_a(m, i).y() - 6);
  }
  CHECK(area == Approx(0.0).margin(1e-12));  // four different corners
}

TEST_CASE("manifold: box on box, shifted, gives the corners of the common rectangle",
          "[collision][analytic]") {
  Fixture f;
  f.add(Box{Vec3(0.5, 0.5, 0.5)}, at(0, 0, 0));
  f.add(Box{Vec3(0.5, 0.5, 0.5)}, at(0.3, -0.2, 0.995));
  f.collect();
  const Manifold& m = only(f);
  check_vec(m.normal, Vec3::UnitZ());
  REQUIRE(m.count == 4);
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    CHECK(f.gap(m, i) == Approx(-0.005).margin(1e-12));
    const Vec3 p = f.on_b(m, i) - Vec3(0.15, -0.1, 0);
    CHECK(std::abs(p.x()) == Approx(0.35));
    CHECK(std::abs(p.y()) == Approx(0.4));
    sum += p.x() * p.y();
  }
  CHECK(sum == Approx(0.0).margin(1e-12));
}

TEST_CASE("manifold: crossing edges of two boxes touch at one point", "[collision][analytic]") {
  // Both stand on an edge; the upper one is turned by a right angle about z.
  const double r = std::sqrt(0.5);
  Fixture f;
  f.add(Box{Vec3(0.5, 0.5, 0.5)}, at(Vec3::Zero(), Vec3(std::numbers::pi / 4, 0, 0)));
  f.add(Box{Vec3(0.5, 0.5, 0.5)},
        at(Vec3(0.1, 0.05, 2 * r - 0.01), Vec3(0, std::numbers::pi / 4, 0)));
  f.collect();
  const Manifold& m = only(f);
  REQUIRE(m.count == 1);
  check_vec(m.normal, Vec3::UnitZ(), 1e-9);
  CHECK(f.gap(m, 0) == Approx(-0.01).margin(1e-9));
  check_vec(f.on_a(m, 0), Vec3(0.1, 0, r), 1e-9);
  check_vec(f.on_b(m, 0), Vec3(0.1, 0, r - 0.01), 1e-9);
}

TEST_CASE(
    "manifold: long bars that cross at hardly a tilt touch on a face, not at one crossing of "
    "their edges",
    "[collision][analytic]") {
  // Bars of 2 m and 0.2 m, along x and along y, 1 mm in each other in the middle.
  const Vec3 half(1.0, 0.1, 0.1);
  for (const double tilt : {0.0, 0.003, 0.01, 0.05}) {
    INFO("tilt " << tilt);
    Fixture f;
    f.add(Box{half}, at(Vec3::Zero(), Vec3(0, tilt, 0)));
    f.add(Box{half},
          {Vec3(0, 0, 0.199), tandem::pbd::exp_map(Vec3(tilt, 0, 0)) *
                                  tandem::pbd::exp_map(Vec3(0, 0, std::numbers::pi / 2))});
    f.collect();
    const Manifold& m = only(f);
    CHECK(m.count == 4);
    CHECK(m.normal.z() > std::cos(1.5 * tilt) - 1e-12);
    for (int i = 0; i < m.count; ++i) {
      // The four places over each other, and how deep two tilted planes are there.
      CHECK(std::abs(f.on_a(m, i).x()) == Approx(0.1).margin(0.1 * tilt + 1e-6));
      CHECK(std::abs(f.on_a(m, i).y()) == Approx(0.1).margin(0.1 * tilt + 1e-6));
      CHECK(f.gap(m, i) == Approx(-0.001).margin(0.25 * tilt + 1e-6));
    }
  }
}

TEST_CASE("manifold: a lying capsule has two points, a standing one hangs on one",
          "[collision][analytic]") {
  const Capsule capsule{0.2, 0.6};
  const Vec3 lying(0, std::numbers::pi / 2, 0);
  for (const bool on_box : {false, true}) {
    Fixture f;
    f.add(capsule, at(Vec3(0, 0.1, 0.195), lying));
    if (on_box) {
      f.fixed(Box{Vec3(2, 2, 1)}, at(0, 0, -1));
    } else {
      f.fixed(HalfSpace{});
    }
    f.collect();
    const Manifold& m = only(f);
    check_vec(m.normal, -Vec3::UnitZ(), 1e-9);
    REQUIRE(m.count == 2);
    CHECK(m.radius_a == 0.2);
    for (int i = 0; i < 2; ++i) {
      CHECK(f.gap(m, i) == Approx(-0.005).margin(1e-9));
      CHECK(std::abs(f.on_a(m, i).x()) == Approx(0.6));
    }
    CHECK(f.on_a(m, 0).x() * f.on_a(m, 1).x() < 0.0);
  }
  Fixture standing;
  standing.add(capsule, at(0, 0, 0.79));
  standing.fixed(HalfSpace{});
  standing.collect();
  CHECK(only(standing).count == 1);
  CHECK(standing.gap(only(standing), 0) == Approx(-0.01).margin(1e-12));
}

TEST_CASE("manifold: a capsule over the edge of a box stands on the part above the box",
          "[collision][analytic]") {
  Fixture f;
  f.add(Capsule{0.2, 0.6}, at(Vec3(1.0, 0, 0.19), Vec3(0, std::numbers::pi / 2, 0)));
  f.fixed(Box{Vec3(1, 1, 1)}, at(0, 0, -1));
  f.collect();
  const Manifold& m = only(f);
  REQUIRE(m.count == 2);
  const double low = std::min(f.on_b(m, 0).x(), f.on_b(m, 1).x());
  const double high = std::max(f.on_b(m, 0).x(), f.on_b(m, 1).x());
  CHECK(low == Approx(0.4));
  CHECK(high == Approx(1.0));
}

TEST_CASE("manifold: capsules side by side have two points, crossed ones have one",
          "[collision][analytic]") {
  Fixture f;
  f.add(Capsule{0.2, 0.6}, at(0, 0, 0));
  f.add(Capsule{0.3, 0.6}, at(0.49, 0, 0.4));
  f.collect();
  const Manifold& side = only(f);
  REQUIRE(side.count == 2);
  check_vec(side.normal, Vec3::UnitX(), 1e-9);
  CHECK(std::min(f.on_a(side, 0).z(), f.on_a(side, 1).z()) == Approx(-0.2));
  CHECK(std::max(f.on_a(side, 0).z(), f.on_a(side, 1).z()) == Approx(0.6));

  Fixture g;
  g.add(Capsule{0.2, 0.6}, at(0, 0, 0));
  g.add(Capsule{0.3, 0.6}, at(Vec3(0.49, 0.1, 0.4), Vec3(std::numbers::pi / 2, 0, 0)));
  g.collect();
  const Manifold& crossed = only(g);
  REQUIRE(crossed.count == 1);
  check_vec(crossed.normal, Vec3::UnitX(), 1e-9);
  CHECK(g.gap(crossed, 0) == Approx(-0.01).margin(1e-12));
  check_vec(g.on_a(crossed, 0), Vec3(0, 0, 0.4), 1e-9);
}

TEST_CASE("manifold: every pair of kinds is mirrored when it is added the other way round",
          "[collision][unit]") {
  const std::vector<Shape> shapes{Sphere{0.4}, Capsule{0.3, 0.5}, Box{Vec3(0.4, 0.5, 0.6)},
                                  HalfSpace{}, box_mesh(Vec3(3, 3, 0.5))};
  Random random(11);
  int compared = 0;
  int tied = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = 0; j < shapes.size(); ++j) {
      const bool flat = shapes[i].index() >= 3 && shapes[j].index() >= 3;
      if (flat && i == j) continue;  // these do not touch
      int contacts = 0;
      for (int k = 0; k < 60; ++k) {
        const Pose a{random.vec(0.2), random.quat()};
        const Pose b{random.vec(0.2) + Vec3(0, 0, 0.75), random.quat()};
        const Both both(shapes[i], a, shapes[j], b, BodyType::Dynamic);
        const auto& forward = both.forward.manifolds;
        const auto& backward = both.backward.manifolds;
        REQUIRE(forward.size() == backward.size());
        for (std::size_t n = 0; n < forward.size(); ++n) {
          const Manifold& f = forward[n];
          const Manifold& g = backward[n];
          INFO("kinds " << i << " " << j << " case " << k << " normal " << f.normal.transpose()
                        << " mirrored " << g.normal.transpose());
          ++contacts;
          if (i == 2 && j == 2 && (f.normal + g.normal).norm() > 1e-9) {
            // Deep in each other, two axes may be equally good within the library's 5 %.
            const double depth = -both.forward.deepest(f);
            CHECK(-both.backward.deepest(g) == Approx(depth).epsilon(0.12));
            CHECK(depth > 0.1);
            ++tied;
            continue;
          }
          REQUIRE(f.count == g.count);
          CHECK((f.normal + g.normal).norm() < 1e-9);
          CHECK(f.radius_a == g.radius_b);
          CHECK(f.radius_b == g.radius_a);
          CHECK(both.backward.deepest(g) == Approx(both.forward.deepest(f)).margin(1e-9));
          // If two boxes have more than four points, the choice of four depends on which box comes
          // first.
          if (i == 2 && j == 2 && f.count == 4) continue;
          for (int p = 0; p < f.count; ++p) {
            double nearest = HUGE_VAL;
            for (int q = 0; q < g.count; ++q) {
              nearest =
                  std::min(nearest, (f.points[p].anchor_a_l - g.points[q].anchor_b_l).norm() +
                                        (f.points[p].anchor_b_l - g.points[q].anchor_a_l).norm());
            }
            CHECK(nearest < 1e-9);
          }
        }
      }
      INFO("kinds " << i << " " << j);
      CHECK(contacts > 10);
      compared += contacts;
    }
  }
  CHECK(compared > 500);
  CHECK(tied <= 3);
}

TEST_CASE("manifold: parts in one place still get a finite unit normal", "[collision][fault]") {
  const std::vector<Shape> shapes{Sphere{0.4}, Capsule{0.3, 0.5}, Box{Vec3(0.4, 0.5, 0.6)}};
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      for (const Vec3& turn :
           {Vec3(0, 0, 0), Vec3(0, std::numbers::pi / 2, 0), Vec3(0.3, 0.2, 0.1)}) {
        Fixture f;
        f.add(a, at(Vec3(1, 1, 1), Vec3::Zero()));
        f.add(b, at(Vec3(1, 1, 1), turn));
        f.collect();
        const Manifold& m = only(f);
        CHECK(m.normal.norm() == Approx(1.0));
        REQUIRE(m.count >= 1);
        CHECK(f.deepest(m) < -0.1);
        CHECK(f.deepest(m) > -3.0);
        for (int i = 0; i < m.count; ++i) CHECK(std::isfinite(f.gap(m, i)));
      }
    }
  }
}

TEST_CASE("manifold: contacts are reported before they close, and not far before",
          "[collision][unit]") {
  CollisionOptions options;
  Fixture f(options);
  const BodyId ball = f.add(Sphere{0.5}, at(0, 0, 0.515));
  f.fixed(HalfSpace{});
  CHECK(f.collect().size() == 1);  // gap 15 mm, margin 20 mm
  CHECK(f.gap(f.manifolds[0], 0) == Approx(0.015));
  f.world.set_pose(ball, at(0, 0, 0.525));
  CHECK(f.collect().empty());
  f.world.set_twist(ball, {Vec3(0, 0, -30.0), Vec3::Zero()});
  f.world.set_pose(ball, at(0, 0, 1.0));
  REQUIRE(f.collect().size() == 1);  // falls 0.5 m within the step
  CHECK(f.gap(f.manifolds[0], 0) == Approx(0.5));
  f.world.set_pose(ball, at(0, 0, 1.03));
  CHECK(f.collect().empty());
  f.world.set_twist(ball, {Vec3(0, 0, 30.0), Vec3::Zero()});  // and flies away from it
  f.world.set_pose(ball, at(0, 0, 1.0));
  CHECK(f.collect().empty());
}

TEST_CASE("manifold: fast boxes and balls meet a thin wall before they are through",
          "[collision][unit]") {
  for (const Shape& shape :
       {Shape(Sphere{0.05}), Shape(Box{Vec3::Constant(0.05)}), Shape(Capsule{0.05, 0.05})}) {
    for (const double speed : {1.0, 5.0, 10.0, 20.0}) {
      Fixture f;
      const BodyId id = f.add(shape, at(-0.5, 0.01, 0.02));
      f.fixed(Box{Vec3(0.01, 2, 2)});
      f.world.set_twist(id, {Vec3(speed, 0, 0), Vec3::Zero()});
      bool met = false;
      for (int step = 0; step < 40 && !met; ++step) {
        for (const Manifold& m : f.collect()) {
          met = met || f.deepest(m) <= speed * kDt;
        }
        if (met) break;
        Pose pose = f.world.pose(id);
        pose.position.x() += speed * kDt;
        f.world.set_pose(id, pose);
      }
      CHECK(met);
      CHECK(f.world.pose(id).position.x() < 0.0);
    }
  }
}

TEST_CASE("manifold: features keep their names under small motions", "[collision][unit]") {
  CollisionOptions options;
  options.recycle_distance = 0.0;  // each collect is a query
  Fixture f(options);
  f.add(Box{Vec3(0.5, 0.5, 0.5)}, at(0, 0, 0), BodyType::Static);
  const BodyId top = f.add(Box{Vec3(0.4, 0.4, 0.4)}, at(Vec3(0.3, 0.2, 0.899), Vec3(0, 0, 0.3)));
  f.collect();
  const Manifold first = only(f);
  REQUIRE(first.count == 4);
  Random random(5);
  for (int k = 0; k < 200; ++k) {
    const Vec3 shift = random.vec(1e-3);
    const Vec3 turn = random.vec(5e-4);
    f.world.set_pose(top, {Vec3(0.3, 0.2, 0.8985) + shift,
                           tandem::pbd::exp_map(turn) * tandem::pbd::exp_map(Vec3(0, 0, 0.3))});
    f.collect();
    const Manifold& m = only(f);
    REQUIRE(m.count == 4);
    CHECK(m.key == first.key);
    for (int i = 0; i < 4; ++i) {
      bool found = false;
      for (int j = 0; j < 4; ++j) found = found || m.points[i].feature == first.points[j].feature;
      CHECK(found);
    }
  }
}

TEST_CASE("manifold: a box that slides from tile to tile of a level floor is not held up",
          "[collision][unit]") {
  for (const double hover : {-1e-4, 0.0, 1e-4}) {
    for (const double speed : {0.5, 3.0, 8.0}) {
      Fixture f;
      f.fixed(Box{Vec3(0.5, 2, 0.5)}, at(-0.5, 0, -0.5));
      f.fixed(Box{Vec3(0.5, 2, 0.5)}, at(0.5, 0, -0.5));
      const BodyId id = f.add(Box{Vec3::Constant(0.2)}, at(-0.9, 0, 0.2 + hover));
      f.world.set_twist(id, {Vec3(speed, 0, 0), Vec3::Zero()});
      // Positions before and on the seam; 1 mm is more than any overlap here.
      for (double x = -0.6; x < 0.6; x += 0.0137) {
        if (std::abs(x + 0.2) < 1e-3) continue;
        f.world.set_pose(id, at(x, 0, 0.2 + hover));
        f.collect();
        REQUIRE(!f.manifolds.empty());
        for (const Manifold& m : f.manifolds) {
          INFO("x " << x << " hover " << hover << " speed " << speed);
          CHECK((m.normal - Vec3::UnitZ()).norm() < 1e-9);
        }
      }
    }
  }
}

TEST_CASE("manifold: the lowest of many corners of a hull is never left out",
          "[collision][analytic]") {
  // A prism over a polygon of 64 corners, all within reach of the floor, whichever is the lowest.
  std::vector<Vec3> corners;
  for (int i = 0; i < 64; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 64;
    for (const double z : {-0.01, 0.01}) {
      corners.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), z);
    }
  }
  const auto hull = ConvexHull::make(corners);
  for (int lowest = 0; lowest < 64; lowest += 9) {
    const double towards = 2.0 * std::numbers::pi * lowest / 64;
    const Vec3 hinge(-std::sin(towards), std::cos(towards), 0.0);
    Fixture f;
    Pose pose = at(0, 0, 0.012);
    pose.orientation = Quat(Eigen::AngleAxisd(0.005, hinge));
    f.add(HalfSpace{Vec3::UnitZ(), 0.0}, Pose{}, BodyType::Static);
    f.add(hull, pose);
    f.collect();
    double least = HUGE_VAL;
    for (const Vec3& corner : corners) {
      least = std::min(least, (pose.position + pose.orientation * corner).z());
    }
    REQUIRE(f.manifolds.size() == 1);
    double found = HUGE_VAL;
    for (int i = 0; i < f.manifolds[0].count; ++i) {
      found = std::min(found, f.gap(f.manifolds[0], i));
    }
    // Its neighbours are 12 um higher, and may be chosen for it; those opposite are 5 mm higher.
    CHECK(found == Approx(least).margin(2e-5));
  }
}

}  // namespace manifold_test
