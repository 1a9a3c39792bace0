// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Cylinders, cones, hulls and height fields: depth against brute force, rest, rolling.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fixture.h"
#include "tandem/collision/compound.h"
#include "tandem/pbd/solver.h"

namespace convex_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;
using tandem::pbd::Mat3;

namespace {

Hull random_hull(std::uint64_t seed, int count, double size) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back(random.vec(size));
  return ConvexHull::make(points);
}

Hull box_hull(const Vec3& half) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                        (i & 4) != 0 ? half.z() : -half.z());
  }
  return ConvexHull::make(points);
}

/// Farthest point of a convex shape along a direction, in its own frame, from its definition.
Vec3 farthest(const Shape& shape, const Vec3& d) {
  const double across = std::hypot(d.x(), d.y());
  const Vec3 rim = across > 0.0 ? Vec3(d.x() / across, d.y() / across, 0.0) : Vec3(Vec3::UnitX());
  if (const auto* s = std::get_if<Sphere>(&shape)) return s->radius * d;
  if (const auto* c = std::get_if<Capsule>(&shape)) {
    return c->radius * d + Vec3(0, 0, d.z() > 0 ? c->half_height : -c->half_height);
  }
  if (const auto* b = std::get_if<Box>(&shape)) {
    return b->half_extents.cwiseProduct(d.unaryExpr([](double x) { return x > 0 ? 1.0 : -1.0; }));
  }
  if (const auto* c = std::get_if<Cylinder>(&shape)) {
    return c->radius * rim + Vec3(0, 0, d.z() > 0 ? c->half_height : -c->half_height);
  }
  if (const auto* c = std::get_if<Cone>(&shape)) {
    const Vec3 apex(0, 0, c->half_height);
    const Vec3 base = c->radius * rim - apex;
    return d.dot(apex) > d.dot(base) ? apex : base;
  }
  const Hull& hull = std::get<Hull>(shape);
  Vec3 best = hull->arms()[0];
  for (const Vec3& arm : hull->arms()) {
    if (d.dot(arm) > d.dot(best)) best = arm;
  }
  return hull->centre() + best;
}

double separation(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, const Vec3& n) {
  const Vec3 from_a = pa.to_world(farthest(a, pa.orientation.conjugate() * n));
  const Vec3 from_b = pb.to_world(farthest(b, pb.orientation.conjugate() * -n));
  return n.dot(from_b - from_a);
}

/// Largest separation over all directions: many of them, and from the best ones uphill.
double brute_force(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb) {
  constexpr int kCount = 2000;
  std::vector<std::pair<double, Vec3>> tried;
  for (int i = 0; i < kCount; ++i) {  // a spiral around the sphere
    const double z = 1.0 - (2.0 * i + 1.0) / kCount;
    const double angle = 2.399963229728653 * i;
    const double r = std::sqrt(1.0 - z * z);
    const Vec3 n(r * std::cos(angle), r * std::sin(angle), z);
    tried.emplace_back(separation(a, pa, b, pb, n), n);
  }
  std::partial_sort(tried.begin(), tried.begin() + 6, tried.end(),
                    [](const auto& l, const auto& r) { return l.first > r.first; });
  double best = -HUGE_VAL;
  Random random(1);
  for (int k = 0; k < 6; ++k) {
    auto [value, n] = tried[static_cast<std::size_t>(k)];
    for (double step = 0.1; step > 1e-6; step *= 0.8) {
      for (int i = 0; i < 8; ++i) {
        const Vec3 m = (n + step * random.vec(1.0)).normalized();
        const double s = separation(a, pa, b, pb, m);
        if (s <= value) continue;
        value = s;
        n = m;
      }
    }
    best = std::max(best, value);
  }
  return best;
}

Mesh bumpy_mesh(std::uint32_t n, double spacing, std::vector<double>* heights_out) {
  Random random(5);
  std::vector<double> heights;
  std::vector<Vec3> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      heights.push_back(random.in(-0.2, 0.2));
      vertices.emplace_back(spacing * i, spacing * j, heights.back());
    }
  }
  for (std::uint32_t j = 0; j + 1 < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      triangles.push_back({a, a + 1, a + n + 1});
      triangles.push_back({a, a + n + 1, a + n});
    }
  }
  if (heights_out != nullptr) *heights_out = heights;
  return TriangleMesh::make(vertices, triangles);
}

Field flat_field(double size, std::uint32_t n) {
  const std::vector<double> heights(n * n, 0.0);
  return HeightField::make(n, n, size / (n - 1), size / (n - 1), heights);
}

BodyId dynamic(Fixture& f, const Shape& shape, const Pose& frame, double density = 1000.0) {
  // The body's frame is at the centre of mass; the shape's is where `frame` says.
  const MassProperties mass = mass_properties(shape, density);
  tandem::pbd::BodyDef def;
  def.mass = mass.mass;
  def.inertia = mass.inertia;
  def.pose = {frame.to_world(mass.com), frame.orientation};
  const BodyId id = f.world.add_body(def);
  ColliderDef collider;
  collider.body = id;
  collider.shape = shape;
  collider.local.position = -mass.com;
  f.scene.add(f.world, collider);
  return id;
}

}  // namespace

TEST_CASE("convex: depth and normal of every pair agree with brute force, in both orders",
          "[collision][analytic]") {
  const std::vector<Shape> shapes{Sphere{0.4},        Capsule{0.3, 0.4}, Box{Vec3(0.4, 0.5, 0.3)},
                                  Cylinder{0.4, 0.5}, Cone{0.5, 0.6},    random_hull(3, 14, 0.6)};
  Random random(12);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = 0; j < shapes.size(); ++j) {
      if (i < 3 && j < 3) continue;  // box_sat_test.cpp
      int overlapping = 0;
      for (int k = 0; k < 14; ++k) {
        const Pose pa{random.vec(0.3), random.quat()};
        const Pose pb{random.vec(0.3) + Vec3(0, 0, 0.7), random.quat()};
        Fixture f;
        f.add(shapes[i], pa);
        f.add(shapes[j], pb);
        f.collect();
        const double truth = brute_force(shapes[i], pa, shapes[j], pb);
        INFO("kinds " << i << " " << j << " case " << k << " true separation " << truth);
        if (truth > 0.02) {
          CHECK(f.manifolds.empty());
          continue;
        }
        if (truth > -1e-4) continue;
        ++overlapping;
        REQUIRE(f.manifolds.size() == 1);
        const Manifold& m = f.manifolds[0];
        CHECK(m.normal.norm() == Approx(1.0));
        const double chosen = separation(shapes[i], pa, shapes[j], pb, m.normal);
        CHECK(chosen <= truth + 2e-3);
        CHECK(chosen >= truth * 1.12 - 3e-3);  // a face may be preferred that is a little deeper
        CHECK(f.deepest(m) >= chosen - 1e-6);
        CHECK(f.deepest(m) <= 0.9 * truth + 3e-3);
      }
      INFO("kinds " << i << " " << j);
      CHECK(overlapping >= 3);
    }
  }
}

TEST_CASE("convex: on a half-space the deepest point is the farthest one",
          "[collision][analytic]") {
  Random random(4);
  for (const Shape& shape :
       {Shape(Cylinder{0.4, 0.5}), Shape(Cone{0.5, 0.6}), Shape(random_hull(7, 20, 0.6))}) {
    for (int k = 0; k < 200; ++k) {
      Pose pose{random.vec(1.0), random.quat()};
      const Vec3 lowest = farthest(shape, pose.orientation.conjugate() * -Vec3::UnitZ());
      pose.position.z() = -0.01 - (pose.orientation * lowest).z();
      Fixture f;
      f.add(shape, pose);
      f.fixed(HalfSpace{});
      f.collect();
      REQUIRE(f.manifolds.size() == 1);
      CHECK(f.deepest(f.manifolds[0]) == Approx(-0.01).margin(1e-9));
    }
  }
}

TEST_CASE("convex: the hull of a box has its faces, edges and mass", "[collision][analytic]") {
  const Vec3 half(0.3, 0.5, 0.7);
  std::vector<Vec3> points;
  Random random(2);
  for (int i = 0; i < 200; ++i)
    points.push_back(random.vec(1.0).cwiseProduct(half) + Vec3(9, 8, 7));
  const Hull corners = box_hull(half);
  for (const Vec3& arm : corners->arms()) points.push_back(arm + Vec3(9, 8, 7));
  const Hull hull = ConvexHull::make(points);
  CHECK(hull->arms().size() == 8);
  CHECK(hull->edges().size() == 12);
  REQUIRE(hull->faces().size() == 6);
  for (const auto& face : hull->faces()) CHECK(face.count == 4);
  CHECK(hull->extent() == Approx(0.6));
  const MassProperties mine = mass_properties(hull, 700.0);
  const MassProperties box = mass_properties(Box{half}, 700.0);
  CHECK(mine.mass == Approx(box.mass));
  CHECK((mine.com - Vec3(9, 8, 7)).norm() < 1e-9);
  CHECK((mine.inertia - box.inertia).norm() < 1e-9 * box.inertia.norm());
}

TEST_CASE("convex: a hull holds all its points and is closed", "[collision][unit]") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    std::vector<Vec3> points;
    // Every other one with many points in common planes.
    for (int i = 0; i < 60; ++i) {
      Vec3 p = random.vec(1.0);
      if (seed % 2 == 0) p = (3.0 * p).array().round() / 3.0;
      points.push_back(p);
    }
    const Hull hull = ConvexHull::make(points, 0.0);
    CHECK(hull->arms().size() + hull->faces().size() == hull->edges().size() + 2);  // Euler
    for (const auto& face : hull->faces()) {
      for (const Vec3& p : points) {
        CHECK(face.normal.dot(p - hull->centre()) <= face.offset + 3e-6);
      }
    }
    for (const auto& edge : hull->edges()) CHECK(edge.faces[0] != edge.faces[1]);
  }
}

TEST_CASE("convex: invalid points and heights are refused by name", "[collision][fault]") {
  const auto hull = [](std::vector<Vec3> points) { return ConvexHull::make(points); };
  CHECK_THROWS_WITH(hull({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}),
                    Contains("points must be") && Contains("is 3"));
  CHECK_THROWS_WITH(hull(std::vector<Vec3>(9, Vec3(1, 2, 3))), Contains("one place"));
  CHECK_THROWS_WITH(hull({Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(2, 2, 2), Vec3(3, 3, 3)}),
                    Contains("line"));
  CHECK_THROWS_WITH(
      hull({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(0.5, 0.5, 1e-6)}),
      Contains("plane"));
  CHECK_THROWS_WITH(hull({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, NAN)}),
                    Contains("points[3]") && Contains("finite"));
  std::vector<Vec3> ball;
  Random random(1);
  for (int i = 0; i < 500; ++i) ball.push_back(random.vec(1.0).normalized());
  CHECK_THROWS_WITH(hull(ball), Contains("128"));

  const std::vector<double> four(4, 0.0);
  CHECK_THROWS_WITH(HeightField::make(1, 4, 1.0, 1.0, four),
                    Contains("columns must be") && Contains("is 1"));
  CHECK_THROWS_WITH(HeightField::make(2, 2, 0.0, 1.0, four),
                    Contains("spacing must be") && Contains("is 0"));
  CHECK_THROWS_WITH(HeightField::make(3, 2, 1.0, 1.0, four),
                    Contains("heights.size must be") && Contains("is 4"));
  const std::vector<double> bad{0, 0, NAN, 0};
  CHECK_THROWS_WITH(HeightField::make(2, 2, 1.0, 1.0, bad), Contains("heights[2]"));
}

TEST_CASE("convex: mass, centre and inertia of round shapes agree with Monte Carlo",
          "[collision][analytic]") {
  Random random(8);
  for (const bool cone : {false, true}) {
    const double r = 0.4;
    const double h = 0.7;
    const Shape shape = cone ? Shape(Cone{r, h}) : Shape(Cylinder{r, h});
    const MassProperties p = mass_properties(shape, 2.0);
    double volume = 0.0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    constexpr int kCount = 400000;
    for (int i = 0; i < kCount; ++i) {
      const Vec3 x = random.vec(1.0).cwiseProduct(Vec3(r, r, h));
      const double limit = cone ? r * (h - x.z()) / (2 * h) : r;
      if (std::hypot(x.x(), x.y()) > limit) continue;
      volume += 1.0;
      first += x;
      const Vec3 d = x - p.com;
      second += d.squaredNorm() * Mat3::Identity() - d * d.transpose();
    }
    const double cell = 2.0 * 8.0 * r * r * h / kCount;
    CHECK(p.mass == Approx(cell * volume).epsilon(5e-3));
    CHECK((p.com - first / volume).norm() < 2e-3);
    CHECK((p.inertia - cell * second).norm() < 5e-3 * p.inertia.norm());
  }
}

TEST_CASE("convex: a box cut in two keeps its weight", "[collision][analytic]") {
  const Vec3 half(0.5, 0.3, 0.2);
  const Pose turned = at(Vec3(1, 2, 3), Vec3(0.3, -0.5, 0.8));
  std::vector<CompoundPart> parts;
  for (const double side : {-1.0, 1.0}) {
    Pose local = turned;
    local.position = turned.to_world(Vec3(0.25 * side, 0, 0));
    parts.push_back({Box{Vec3(0.25, 0.3, 0.2)}, local, 500.0});
  }
  const MassProperties cut = mass_properties(parts);
  const MassProperties whole = mass_properties(Box{half}, 500.0);
  const Mat3 turn = turned.orientation.toRotationMatrix();
  CHECK(cut.mass == Approx(whole.mass));
  CHECK((cut.com - Vec3(1, 2, 3)).norm() < 1e-12);
  CHECK((cut.inertia - turn * whole.inertia * turn.transpose()).norm() < 1e-9);
}

TEST_CASE("convex: parts of a compound share their collider's settings", "[collision][unit]") {
  Fixture f;
  f.fixed(HalfSpace{});
  ColliderDef def;
  def.body = f.body(at(0, 0, 0.995));
  def.material.friction = 0.125;
  def.local = at(0, 0, -0.5);
  const std::vector<CompoundPart> parts{{Sphere{0.5}, at(-1, 0, 0)}, {Sphere{0.5}, at(1, 0, 0)}};
  const auto ids = add_compound(f.scene, f.world, def, parts);
  REQUIRE(ids.size() == 2);
  REQUIRE(f.collect().size() == 2);
  for (const Manifold& m : f.manifolds) CHECK(m.friction == Approx(0.25));
  const std::vector<CompoundPart> bad{{Sphere{0.5}, {}}, {Sphere{-1}, {}}};
  const auto slots = f.scene.slot_count();
  CHECK_THROWS_WITH(add_compound(f.scene, f.world, def, bad),
                    Contains("radius must be") && Contains("is -1"));
  CHECK(f.collect().size() == 2);
  CHECK(f.scene.slot_count() <= slots + 1);
}

TEST_CASE("convex: a height field touches like the mesh of its triangles", "[collision][unit]") {
  std::vector<double> heights;
  constexpr std::uint32_t kSide = 12;
  const Mesh mesh = bumpy_mesh(kSide, 0.5, &heights);
  const Field field = HeightField::make(kSide, kSide, 0.5, 0.5, heights);
  REQUIRE(field->triangle_count() == mesh->triangles().size());
  for (std::uint32_t t = 0; t < field->triangle_count(); ++t) {
    CHECK((field->normal(t) - mesh->normal(t)).norm() < 1e-12);
    for (int k = 0; k < 3; ++k) {
      CHECK(field->corners(t)[static_cast<std::size_t>(k)] ==
            mesh->corners(t)[static_cast<std::size_t>(k)]);
      const std::uint32_t across = field->neighbour(t, k);
      CHECK(across == mesh->neighbour(t, k));
      if (across == HeightField::kNone) continue;
      bool shared = false;
      for (int i = 0; i < 3; ++i)
        shared = shared || field->edge_id(across, i) == field->edge_id(t, k);
      CHECK(shared);
    }
  }
  for (std::uint32_t v = 0; v < field->vertex_count(); ++v) {
    const auto ring = field->ring(v);
    std::vector<std::uint32_t> mine(ring.begin(), ring.end());
    std::vector<std::uint32_t> theirs(mesh->ring(v).begin(), mesh->ring(v).end());
    std::sort(mine.begin(), mine.end());
    std::sort(theirs.begin(), theirs.end());
    CHECK(mine == theirs);
  }
  Random random(6);
  int contacts = 0;
  for (const Shape& shape :
       {Shape(Sphere{0.3}), Shape(Box{Vec3(0.3, 0.2, 0.25)}), Shape(Capsule{0.2, 0.3}),
        Shape(Cylinder{0.3, 0.2}), Shape(random_hull(3, 12, 0.35))}) {
    for (int k = 0; k < 100; ++k) {
      const double x = random.in(0.5, 5.0);
      const Pose pose{Vec3(x, random.in(0.5, 5.0), random.in(-0.1, 0.6)), random.quat()};
      Fixture on_mesh, on_field;
      on_mesh.fixed(mesh);
      on_field.fixed(field);
      on_mesh.add(shape, pose);
      on_field.add(shape, pose);
      on_mesh.collect();
      on_field.collect();
      REQUIRE(on_mesh.manifolds.size() == on_field.manifolds.size());
      for (std::size_t i = 0; i < on_mesh.manifolds.size(); ++i) {
        const Manifold& m = on_mesh.manifolds[i];
        const Manifold& n = on_field.manifolds[i];
        ++contacts;
        // Round sides are climbed, which ends somewhere on a flat top.
        const bool round = std::holds_alternative<Cylinder>(shape);
        CHECK((m.normal - n.normal).norm() < (round ? 2e-2 : 1e-9));
        CHECK(on_mesh.deepest(m) == Approx(on_field.deepest(n)).margin(round ? 1e-3 : 1e-9));
        if (!round) REQUIRE(m.count == n.count);
      }
    }
  }
  CHECK(contacts > 300);
}

TEST_CASE("convex: a sphere touches cylinders and cones where they are", "[collision][analytic]") {
  Random random(15);
  for (const Shape& shape : {Shape(Cylinder{0.4, 0.5}), Shape(Cone{0.5, 0.6})}) {
    int near = 0;
    for (int k = 0; k < 400; ++k) {
      const Pose pose{random.vec(0.2), random.quat()};
      const Vec3 centre = random.vec(0.9);
      Fixture f;
      f.add(Sphere{0.2}, {centre, Quat::Identity()});
      f.add(shape, pose);
      f.collect();
      const double truth = brute_force(Sphere{0.2}, {centre, Quat::Identity()}, shape, pose);
      INFO("case " << k << " truth " << truth);
      if (truth > 0.02) {
        CHECK(f.manifolds.empty());
        continue;
      }
      if (truth > 0.019) continue;
      ++near;
      REQUIRE(f.manifolds.size() == 1);
      // Brute force does not quite get there.
      CHECK(f.deepest(f.manifolds[0]) >= truth - 1e-9);
      CHECK(f.deepest(f.manifolds[0]) <= truth + 1e-3);
    }
    CHECK(near > 50);
  }
}

TEST_CASE("convex: at rest on every ground nothing drifts", "[collision][soak]") {
  struct Rest {
    const char* name;
    Shape shape;
    double height;
    Vec3 turn;
  };
  const std::vector<Rest> rests{
      {"box", Box{Vec3(0.3, 0.4, 0.25)}, 0.25, Vec3::Zero()},
      {"cylinder standing", Cylinder{0.3, 0.4}, 0.4, Vec3::Zero()},
      {"cylinder lying", Cylinder{0.3, 0.4}, 0.3, Vec3(0, std::numbers::pi / 2, 0)},
      {"cone", Cone{0.4, 0.5}, 0.5, Vec3::Zero()},
      {"hull", box_hull(Vec3(0.3, 0.4, 0.25)), 0.25, Vec3::Zero()},
  };
  const std::vector<std::pair<const char*, Shape>> grounds{
      {"half-space", HalfSpace{}},         {"box", Box{Vec3(4, 4, 0.5)}},
      {"mesh", flat_mesh(8.0, 9)},         {"field", flat_field(8.0, 10)},
      {"hull", box_hull(Vec3(4, 4, 0.5))}, {"cylinder", Cylinder{4.0, 0.5}}};
  for (const auto& [ground_name, ground] : grounds) {
    for (const Rest& rest : rests) {
      Fixture f;
      const bool thick = ground.index() == 2 || ground.index() == 5 || ground.index() == 7;
      const Vec3 corner = ground.index() == 8 ? Vec3(-4, -4, 0) : Vec3(0, 0, thick ? -0.5 : 0.0);
      f.fixed(ground, {corner, Quat::Identity()});
      const BodyId id = dynamic(f, rest.shape, at(Vec3(0.13, 0.07, rest.height), rest.turn));
      const BodyId twin = dynamic(f, rest.shape, at(Vec3(-2, 1, rest.height + 0.05), rest.turn));
      f.world.set_contact_source(&f.scene);
      tandem::pbd::Solver solver;
      const Pose before = f.world.pose(id);
      for (int step = 0; step < 180; ++step) (void)solver.step(f.world, kDt);
      INFO(rest.name << " on " << ground_name);
      const Pose& after = f.world.pose(id);
      CHECK((after.position - before.position).norm() < 1e-3);
      CHECK(std::abs((after.orientation * before.orientation.conjugate()).vec().norm()) < 1e-3);
      CHECK(f.world.twist(id).linear.norm() < 1e-4);
      // The one that was dropped by 5 cm has come to rest on the same side.
      CHECK(f.world.pose(twin).position.z() == Approx(after.position.z()).margin(1e-3));
      CHECK(f.world.twist(twin).linear.norm() < 1e-2);
    }
  }
}

TEST_CASE("convex: a cylinder rolls on its side without bumping", "[collision][analytic]") {
  for (const bool on_box : {false, true}) {
    Fixture f;
    f.fixed(on_box ? Shape(Box{Vec3(20, 4, 0.5)}) : Shape(HalfSpace{}),
            at(0, 0, on_box ? -0.5 : 0.0));
    const BodyId id =
        dynamic(f, Cylinder{0.3, 0.4}, at(Vec3(-5, 0, 0.3), Vec3(std::numbers::pi / 2, 0, 0)));
    // Rolling without slip about y.
    f.world.set_twist(id, {Vec3(3, 0, 0), Vec3(0, 10, 0)});
    f.world.set_contact_source(&f.scene);
    tandem::pbd::Solver solver;
    double highest = 0.0;
    for (int step = 0; step < 120; ++step) {
      (void)solver.step(f.world, kDt);
      highest = std::max(highest, std::abs(f.world.pose(id).position.z() - 0.3));
    }
    INFO((on_box ? "box" : "half-space"));
    CHECK(highest < 1e-4);
    CHECK(f.world.twist(id).linear.x() == Approx(3.0).epsilon(2e-3));
    CHECK(f.world.pose(id).position.x() == Approx(1.0).margin(0.02));
  }
}

TEST_CASE("convex: a part of a compound in no place is refused", "[collision][fault]") {
  std::vector<CompoundPart> parts{{Sphere{0.5}, at(-1, 0, 0)}, {Sphere{0.5}, at(1, 0, 0)}};
  parts[1].local.position.y() = std::nan("");
  CHECK_THROWS_WITH(mass_properties(parts), Catch::Contains("parts[1].local.position") &&
                                                Catch::Contains("nan") &&
                                                Catch::Contains("finite"));
  parts[1].local = at(1, 0, 0);
  parts[0].local.orientation = Quat(0.0, 0.0, 0.0, 0.0);
  CHECK_THROWS_WITH(mass_properties(parts),
                    Catch::Contains("parts[0].local.orientation") && Catch::Contains("unit norm"));
}

}  // namespace convex_test
