// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/scene_query.h"

#include <algorithm>
#include <thread>

#include "allocation_count.h"
#include "fixture.h"
#include "tandem/pbd/solver.h"

namespace scene_query_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;

namespace {

/// Whether the solid holds the point; by the definitions in shape.h, not by the code under test.
bool holds(const Shape& shape, const Vec3& p) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return p.norm() <= s->radius;
  if (const auto* b = std::get_if<Box>(&shape)) {
    return (p.cwiseAbs().array() <= b->half_extents.array()).all();
  }
  if (const auto* c = std::get_if<Capsule>(&shape)) {
    const double z = std::clamp(p.z(), -c->half_height, c->half_height);
    return (p - Vec3(0, 0, z)).norm() <= c->radius;
  }
  if (const auto* c = std::get_if<Cylinder>(&shape)) {
    return std::abs(p.z()) <= c->half_height && std::hypot(p.x(), p.y()) <= c->radius;
  }
  if (const auto* c = std::get_if<Cone>(&shape)) {
    const double share = 0.5 * (1.0 - p.z() / c->half_height);  // of the base's radius
    return std::abs(p.z()) <= c->half_height && std::hypot(p.x(), p.y()) <= share * c->radius;
  }
  if (const auto* h = std::get_if<Hull>(&shape)) {  // those of this test are boxes
    return (p.cwiseAbs().array() <= (*h)->bounds().max.array()).all();
  }
  if (const auto* h = std::get_if<HalfSpace>(&shape)) return h->normal.dot(p) <= h->offset;
  return false;
}

/// A box by its corners.
Shape box_hull(const Vec3& half) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                         (i & 4) != 0 ? half.z() : -half.z());
  }
  return ConvexHull::make(corners);
}

/// Solids strewn about `centre`, each turned, over a floor.
struct Scatter : Fixture {
  Vec3 centre;
  explicit Scatter(const Vec3& at_centre = Vec3::Zero(), std::uint64_t seed = 5)
      : centre(at_centre) {
    Random random(seed);
    fixed(HalfSpace{Vec3::UnitZ(), 0.0}, {centre - 4.0 * Vec3::UnitZ(), Quat::Identity()});
    for (int i = 0; i < 60; ++i) {
      const double size = random.in(0.1, 0.6);
      const Shape shape = i % 6 == 0   ? Shape(Sphere{size})
                          : i % 6 == 1 ? Shape(Box{size * random.vec_in(0.5, 1.0)})
                          : i % 6 == 2 ? Shape(Capsule{0.4 * size, size})
                          : i % 6 == 3 ? Shape(Cylinder{0.5 * size, size})
                          : i % 6 == 4 ? Shape(Cone{0.8 * size, size})
                                       : box_hull(size * random.vec_in(0.5, 1.0));
      ColliderDef def;
      def.shape = shape;
      def.local = {0.3 * random.vec(1.0), random.quat()};
      const Vec3 position = random.vec(4.0);
      def.body = body({centre + position, random.quat()});
      scene.add(world, def);
    }
  }
  /// The lowest collider that holds the point, or an invalid id.
  ColliderId holder(const Vec3& p) const {
    for (std::uint32_t i = 0; i < scene.slot_count(); ++i) {
      const ColliderDef& def = scene.collider(scene.collider_at(i));
      if (holds(def.shape, def.local.to_local(world.pose(def.body).to_local(p)))) {
        return scene.collider_at(i);
      }
    }
    return {};
  }
};

}  // namespace

TEST_CASE("scene_query: a ray's first hit is where it enters the first solid",
          "[collision][query]") {
  Scatter f;
  const SceneQuery query(f.world, f.scene);
  Random random(21);
  int hits = 0;
  for (int i = 0; i < 800; ++i) {
    const Vec3 from = random.vec(6.0) + Vec3(0, 0, 3.0);
    const Vec3 direction = random.vec(1.0);
    if (f.holder(from).valid()) continue;
    const auto hit = query.ray_cast({from, direction, 12.0});
    CHECK(query.ray_blocked({from, direction, 12.0}) == hit.has_value());
    const Vec3 unit = direction.normalized();
    const double end = hit ? hit->distance : 12.0;
    for (int k = 0; k < 600; ++k) {
      const double t = end * k / 600.0;
      if (end - t > 1e-9) REQUIRE_FALSE(f.holder(from + t * unit).valid());
    }
    if (!hit) continue;
    ++hits;
    REQUIRE((hit->point - (from + hit->distance * unit)).norm() < 1e-12);
    REQUIRE(hit->fraction == Approx(hit->distance / 12.0));
    REQUIRE(hit->normal.dot(unit) < 0.0);
    REQUIRE(hit->normal.norm() == Approx(1.0));
    const ColliderDef& def = f.scene.collider(hit->collider);
    REQUIRE(def.body == hit->body);
    const Pose& pose = f.world.pose(def.body);
    const auto inside = [&](const Vec3& p) {
      return holds(def.shape, def.local.to_local(pose.to_local(p)));
    };
    REQUIRE(inside(hit->point - 1e-7 * hit->normal));
    REQUIRE_FALSE(inside(hit->point + 1e-7 * hit->normal));
  }
  CHECK(hits > 150);
}

TEST_CASE("scene_query: all hits come by distance, one for each collider", "[collision][query]") {
  Fixture f;
  for (int i = 0; i < 5; ++i) f.fixed(Sphere{0.5}, at(2.0 * (5 - i), 0, 0));
  f.fixed(Box{Vec3::Constant(0.5)}, at(4, 0, 0));  // in the place of a ball
  const SceneQuery query(f.world, f.scene);
  std::vector<RayHit> hits;
  query.ray_cast_all({Vec3::Zero(), Vec3(2, 0, 0), 8.0}, hits);
  REQUIRE(hits.size() == 5);
  const std::vector<std::uint32_t> expected{4, 3, 5, 2, 1};
  for (std::size_t i = 0; i < hits.size(); ++i) CHECK(hits[i].collider.index == expected[i]);
  CHECK(hits[0].distance == Approx(1.5));
  CHECK(hits[1].distance == hits[2].distance);
  CHECK(query.ray_cast({Vec3::Zero(), Vec3(2, 0, 0), 8.0})->collider.index == 4);
}

TEST_CASE("scene_query: rays that graze, start inside or run along a face",
          "[collision][query][analytic]") {
  Fixture f;
  f.fixed(Sphere{1.0});
  f.fixed(Box{Vec3(1, 2, 3)}, at(10, 0, 0));
  f.fixed(Capsule{0.5, 1.0}, at(20, 0, 0));
  f.fixed(HalfSpace{}, at(0, 0, -10));
  const SceneQuery query(f.world, f.scene);
  const auto cast = [&](const Vec3& from, const Vec3& direction) {
    return query.ray_cast({from, direction, 100.0});
  };
  CHECK(cast(Vec3(-5, 1.0 - 1e-12, 0), Vec3::UnitX())->point.x() == Approx(0.0).margin(2e-6));
  CHECK(cast(Vec3(-5, 1.0 + 1e-9, 0), Vec3::UnitX())->collider.index == 1);  // past the ball
  const auto inside = cast(Vec3(0, 0.8, 0), Vec3::UnitX());
  CHECK(inside->distance == 0.0);
  CHECK((inside->normal - Vec3::UnitY()).norm() < 1e-12);
  const auto in_box = cast(Vec3(10.9, 0.1, 0.2), Vec3::UnitY());
  CHECK(in_box->distance == 0.0);
  CHECK((in_box->normal - Vec3::UnitX()).norm() < 1e-12);
  CHECK(cast(Vec3(10, -5, 3), Vec3::UnitY())->distance == Approx(3.0));  // within the top face
  CHECK(cast(Vec3(20.2, 0, 5), -Vec3::UnitZ())->distance == Approx(4.0 - std::sqrt(0.25 - 0.04)));
  CHECK(cast(Vec3(20.5, 0, 5), -Vec3::UnitZ())->collider.index == 2);  // along the side
  CHECK(cast(Vec3(50, 0, 0), Vec3(1, 0, -1e-3)) == std::nullopt);      // too far
  CHECK(cast(Vec3(50, 0, 0), Vec3(1, 0, -1))->distance == Approx(10.0 * std::sqrt(2.0)));
  CHECK(cast(Vec3(50, 0, 0), Vec3(1, 0, 0)) == std::nullopt);  // along the floor
  CHECK(cast(Vec3(50, 0, -11), Vec3::UnitX())->normal == Vec3::UnitZ());
  CHECK(cast(Vec3(-5, 0, 0), Vec3(1e-200, 0, 0))->distance == Approx(4.0));
}

TEST_CASE("scene_query: no ray slips between the triangles of a mesh", "[collision][query]") {
  Fixture f;
  const Mesh mesh = flat_mesh(4.0, 6);
  const BodyId ground = f.fixed(mesh, {Vec3(3, 1, 2), Quat(0.9, 0.1, -0.3, 0.2).normalized()});
  const SceneQuery query(f.world, f.scene);
  Random random(8);
  const Pose& pose = f.world.pose(ground);
  for (int i = 0; i < 3000; ++i) {
    // Towards corners, points of edges and points of the inner lines, from the front.
    const auto& t = mesh->triangles()[static_cast<std::size_t>(i) % mesh->triangles().size()];
    const Vec3 a = mesh->vertices()[t[0]];
    const Vec3 b = mesh->vertices()[t[1]];
    const Vec3 target_l = 0.98 * (i % 3 == 0 ? a : Vec3(a + random.in(0, 1) * (b - a)));
    const Vec3 target = pose.to_world(i % 5 == 0 ? target_l : Vec3(target_l / 0.98 * 0.999999));
    const Vec3 from = target + pose.orientation * Vec3(random.in(-2, 2), random.in(-2, 2), 1.0);
    const auto hit = query.ray_cast({from, target - from, 50.0});
    REQUIRE(hit);
    REQUIRE((hit->point - target).norm() < 1e-9);
    REQUIRE(hit->triangle < mesh->triangles().size());
    REQUIRE((hit->normal - pose.orientation * Vec3::UnitZ()).norm() < 1e-12);
    const Vec3 below = target - 2.0 * hit->normal;
    REQUIRE_FALSE(query.ray_cast({below, target - below, 50.0}));  // a back stops nothing
    REQUIRE(query.ray_cast({below, target - below, 50.0}, {.back_faces = true}));
  }
}

TEST_CASE("scene_query: a height field answers as the mesh of its triangles",
          "[collision][query]") {
  Random random(14);
  std::vector<double> heights;
  for (int i = 0; i < 9 * 7; ++i) heights.push_back(random.in(-0.5, 0.5));
  const Field field = HeightField::make(9, 7, 0.8, 0.6, heights);
  std::vector<Vec3> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
  for (std::uint32_t v = 0; v < field->vertex_count(); ++v) vertices.push_back(field->vertex(v));
  for (std::uint32_t t = 0; t < field->triangle_count(); ++t) {
    triangles.push_back(field->corners(t));
  }
  const Pose pose{Vec3(1, 2, 3), random.quat()};
  Fixture one;
  one.fixed(field, pose);
  Fixture two;
  two.fixed(TriangleMesh::make(vertices, triangles), pose);
  const SceneQuery a(one.world, one.scene);
  const SceneQuery b(two.world, two.scene);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 from = pose.to_world(random.vec_in(0.0, 1.0).cwiseProduct(Vec3(6, 4, 3)));
    const Vec3 way = pose.orientation * Vec3(random.in(-2, 2), random.in(-2, 2), -4);
    const auto ray_a = a.ray_cast({from, way, 8.0});
    const auto ray_b = b.ray_cast({from, way, 8.0});
    REQUIRE(ray_a.has_value() == ray_b.has_value());
    if (ray_a) {
      ++hits;
      REQUIRE(ray_a->triangle == ray_b->triangle);
      REQUIRE((ray_a->point - ray_b->point).norm() < 1e-9);
    }
    const Pose start{from, random.quat()};
    const auto cast_a = a.shape_cast(Box{Vec3::Constant(0.1)}, start, way);
    const auto cast_b = b.shape_cast(Box{Vec3::Constant(0.1)}, start, way);
    REQUIRE(cast_a.has_value() == cast_b.has_value());
    if (cast_a) REQUIRE(cast_a->fraction == Approx(cast_b->fraction).margin(1e-9));
    const auto near_a = a.closest(from, 5.0);
    const auto near_b = b.closest(from, 5.0);
    REQUIRE(near_a->distance == Approx(near_b->distance).margin(1e-9));
  }
  CHECK(hits > 300);
}

TEST_CASE("scene_query: a cast ends at the first body that it meets",
          "[collision][query][analytic]") {
  Fixture f;
  f.fixed(flat_mesh(20.0, 7), at(0, 0, 0));
  f.fixed(Sphere{1.0}, at(5, 0, 3));
  const SceneQuery query(f.world, f.scene);
  const Vec3 down(0, 0, -10);
  const auto ball = query.shape_cast(Sphere{0.5}, at(0.3, 0.2, 5), down);
  REQUIRE(ball);
  CHECK(ball->fraction == Approx(0.45).epsilon(1e-8));
  CHECK((ball->point - Vec3(0.3, 0.2, 0)).norm() < 1e-7);
  CHECK((ball->normal - Vec3::UnitZ()).norm() < 1e-7);
  const auto box = query.shape_cast(Box{Vec3::Constant(0.5)}, at(0.1, 0.2, 5), down);
  CHECK(box->fraction == Approx(0.45).epsilon(1e-8));
  CHECK(box->triangle != TriangleMesh::kNone);
  // A corner first: a cube on its tip is sqrt(3) edges high.
  const Quat tip = Quat::FromTwoVectors(Vec3(1, 1, 1).normalized(), Vec3::UnitZ());
  CHECK(query.shape_cast(Box{Vec3::Constant(0.5)}, {Vec3(0, 0, 5), tip}, down)->fraction ==
        Approx(0.5 - 0.05 * std::sqrt(3.0)).epsilon(1e-8));
  CHECK(query.shape_cast(Capsule{0.2, 1.0}, at(0, 0, 5), down)->fraction == Approx(0.38));
  CHECK(query.shape_cast(Sphere{1.0}, at(5, 0, 9), down)->fraction == Approx(0.4));
  CHECK_FALSE(query.shape_cast(Sphere{0.5}, at(0, 0, 1), Vec3(0, 0, 10)));
  CHECK_FALSE(query.shape_cast(Sphere{0.5}, at(0, 0, -3), Vec3(0, 0, 10)));  // a back

  const auto overlap = query.shape_cast(Sphere{0.5}, at(1, 1, 0.4), Vec3::Zero());
  REQUIRE(overlap);
  CHECK(overlap->fraction == 0.0);
  CHECK(overlap->depth == Approx(0.1));
  CHECK((overlap->normal - Vec3::UnitZ()).norm() < 1e-9);
  const auto deep = query.shape_cast(Sphere{0.5}, at(5.9, 0, 3), Vec3(1, 0, 0));
  CHECK(deep->fraction == 0.0);
  CHECK(deep->depth == Approx(0.6));
  CHECK((deep->normal - Vec3::UnitX()).norm() < 1e-12);
  std::vector<CastHit> all;
  query.shape_cast_all(Sphere{1.0}, at(5, 0, 9), down, all);
  REQUIRE(all.size() == 2);
  CHECK(all[0].collider.index == 1);
  CHECK(all[1].fraction == Approx(0.8));
}

TEST_CASE("scene_query: overlap and nearest points agree with sampling", "[collision][query]") {
  Scatter f;
  const SceneQuery query(f.world, f.scene);
  Random random(31);
  std::vector<ColliderId> found;
  for (int i = 0; i < 60; ++i) {
    const Pose pose{random.vec(4.0), random.quat()};
    const Box box{random.vec_in(0.1, 0.8)};
    found.clear();
    query.overlap(box, pose, found);
    CHECK(query.overlaps(box, pose) == !found.empty());
    CHECK(std::is_sorted(found.begin(), found.end()));
    // Every sample of the box that lies in a collider proves its overlap.
    for (int k = 0; k < 300; ++k) {
      const Vec3 p = pose.to_world(box.half_extents.cwiseProduct(random.vec(1.0)));
      const ColliderId holder = f.holder(p);
      if (holder.valid()) REQUIRE(std::binary_search(found.begin(), found.end(), holder));
    }
    // Overlapping pairs have distance 0, and a plane separates the others.
    for (std::uint32_t c = 0; c < f.scene.slot_count(); ++c) {
      const ColliderId id = f.scene.collider_at(c);
      const auto near = query.closest_on(id, box, pose, 100.0);
      REQUIRE(near);
      const bool overlaps = std::binary_search(found.begin(), found.end(), id);
      REQUIRE(overlaps == (near->distance <= 1e-9));
      if (overlaps) continue;
      REQUIRE((near->on_shape - near->on_collider - near->distance * near->normal).norm() < 1e-9);
      const Vec3 on_box = pose.to_local(near->on_shape).cwiseAbs() - box.half_extents;
      REQUIRE(on_box.maxCoeff() < 1e-9);
    }
  }
}

TEST_CASE("scene_query: the nearest of all is the nearest of each", "[collision][query]") {
  Scatter f;
  const SceneQuery query(f.world, f.scene);
  Random random(32);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = random.vec(5.0);
    const auto best = query.closest(p, 3.0);
    double least = HUGE_VAL;
    for (std::uint32_t c = 0; c < f.scene.slot_count(); ++c) {
      const auto hit = query.closest_on(f.scene.collider_at(c), p, 3.0);
      if (hit) least = std::min(least, hit->distance);
    }
    REQUIRE(best.has_value() == (least < HUGE_VAL));
    if (!best) continue;
    REQUIRE(best->distance == least);
    REQUIRE((best->distance < 0.0) == f.holder(p).valid());
    std::vector<ClosestHit> all;
    const auto ball = query.closest(Sphere{0.1}, {p, Quat::Identity()}, 2.9);
    REQUIRE(ball.has_value() == best.has_value());
    // A ball is nearer by its radius, wherever it does not overlap.
    if (best && best->distance > 0.1)
      CHECK(ball->distance == Approx(best->distance - 0.1).margin(1e-6));
    query.closest_all(Sphere{1e-3}, {p, Quat::Identity()}, 3.0, all);
    REQUIRE(all.front().distance == Approx(least - 1e-3).margin(1e-9));
  }
}

TEST_CASE("scene_query: the inside of a closed mesh overlaps, that of an open one does not",
          "[collision][query]") {
  Fixture f;
  f.fixed(box_mesh(Vec3(2, 2, 2)), at(0, 0, 0));
  f.fixed(flat_mesh(4.0, 3), at(10, 0, 0));
  const SceneQuery query(f.world, f.scene);
  CHECK(query.overlaps(Sphere{0.1}, at(0.5, 0.2, 0.1)));
  CHECK(query.overlaps(Sphere{0.1}, at(1.95, 0.2, 0.1)));
  CHECK_FALSE(query.overlaps(Sphere{0.1}, at(2.2, 0.2, 0.1)));
  CHECK_FALSE(query.overlaps(Sphere{0.1}, at(10, 0, -0.2)));
  CHECK(query.overlaps(Sphere{0.1}, at(10, 0, -0.05)));
  CHECK(query.closest(Vec3(1.5, 0, 0), 10.0)->distance == Approx(0.5));
}

TEST_CASE("scene_query: filters, sensors, an ignored body and a predicate leave colliders out",
          "[collision][query]") {
  Fixture f;
  const auto ball = [&](double x, const Filter& filter, bool sensor) {
    const BodyId id = f.body(at(x, 0, 0));
    f.scene.add(f.world, {.body = id, .shape = Sphere{0.5}, .filter = filter, .sensor = sensor});
    return id;
  };
  const BodyId first = ball(2, {.category = 2}, false);
  ball(4, {.category = 4, .mask = 8}, false);
  ball(6, {}, true);
  ball(8, {}, false);
  const SceneQuery query(f.world, f.scene);
  const Ray ray{Vec3::Zero(), Vec3::UnitX(), 20.0};
  const auto hit = [&](const QueryFilter& filter) {
    const auto found = query.ray_cast(ray, filter);
    return found ? static_cast<int>(found->collider.index) : -1;
  };
  CHECK(hit({}) == 0);
  CHECK(hit({.filter = {.category = ~0u, .mask = ~2u}}) == 1);
  CHECK(hit({.filter = {.category = 1, .mask = ~2u}}) == 3);
  CHECK(hit({.filter = {.category = 1, .mask = ~2u}, .sensors = true}) == 2);
  CHECK(hit({.ignore_body = first}) == 1);
  CHECK(hit({.accept = [](ColliderId id) { return id.index == 3; }}) == 3);
  CHECK(hit({.filter = {.mask = 0}}) == -1);
}

TEST_CASE("scene_query: queries see where bodies are now, wherever they were",
          "[collision][query]") {
  Scatter f;
  f.collect();
  SceneQuery query(f.world, f.scene);
  Random random(77);
  for (int round = 0; round < 4; ++round) {
    for (std::uint32_t i = 1; i < f.world.slot_count(); ++i) {
      if (random.in(0, 1) < 0.5) continue;
      f.world.set_pose(f.world.body_at(i), {random.vec(4.0), random.quat()});
    }
    const std::uint32_t gone = 1 + static_cast<std::uint32_t>(round);
    f.scene.remove(f.scene.collider_at(gone));
    if (round == 2) f.add(Sphere{0.7}, at(0, 0, 0));  // takes a freed slot
    query.update(f.world, f.scene);
    const SceneQuery fresh(f.world, f.scene);
    for (int i = 0; i < 100; ++i) {
      const Ray ray{random.vec(5.0), random.vec(1.0), 20.0};
      const auto one = query.ray_cast(ray);
      const auto two = fresh.ray_cast(ray);
      REQUIRE(one.has_value() == two.has_value());
      if (!one) continue;
      REQUIRE(one->collider == two->collider);
      REQUIRE(one->distance == two->distance);
      REQUIRE(f.scene.contains(one->collider));
    }
  }
}

TEST_CASE("scene_query: the same answers 100 km from the origin", "[collision][query]") {
  const Vec3 far(1e5, -1e5, 1e5);
  Scatter near_field;
  Scatter far_field(far);
  const SceneQuery here(near_field.world, near_field.scene);
  const SceneQuery there(far_field.world, far_field.scene);
  Random random(9);
  for (int i = 0; i < 300; ++i) {
    const Vec3 from = random.vec(5.0);
    const Vec3 direction = random.vec(1.0);
    const auto one = here.ray_cast({from, direction, 20.0});
    const auto two = there.ray_cast({far + from, direction, 20.0});
    REQUIRE(one.has_value() == two.has_value());
    if (one) REQUIRE(std::abs(one->distance - two->distance) < 1e-7);
    const Pose pose{from, random.quat()};
    const auto cast = here.shape_cast(Box{Vec3(0.1, 0.2, 0.3)}, pose, 10.0 * direction);
    const auto cast_far = there.shape_cast(Box{Vec3(0.1, 0.2, 0.3)}, {far + from, pose.orientation},
                                           10.0 * direction);
    REQUIRE(cast.has_value() == cast_far.has_value());
    if (cast) REQUIRE(std::abs(cast->fraction - cast_far->fraction) < 1e-6);
  }
}

TEST_CASE("scene_query: input that cannot be is refused by name, value and rule",
          "[collision][query][fault]") {
  Fixture f;
  f.fixed(Sphere{1.0});
  const SceneQuery query(f.world, f.scene);
  CHECK_THROWS_WITH(
      query.ray_cast({Vec3::Zero(), Vec3::Zero(), 1.0}),
      Contains("Ray: direction must be") && Contains("is 0") && Contains("longer than 0"));
  CHECK_THROWS_WITH(query.ray_cast({Vec3(0, NAN, 0), Vec3::UnitX(), 1.0}),
                    Contains("Ray: origin must be") && Contains("is nan"));
  CHECK_THROWS_WITH(query.ray_blocked({Vec3::Zero(), Vec3::UnitX(), INFINITY}),
                    Contains("Ray: max_distance must be") && Contains("is inf"));
  CHECK_THROWS_WITH(query.overlaps(HalfSpace{}, {}), Contains("a convex shape"));
  CHECK_THROWS_WITH(query.overlaps(Sphere{-1}, {}),
                    Contains("Sphere.radius must be") && Contains("is -1"));
  CHECK_THROWS_WITH(query.shape_cast(Sphere{1}, {}, Vec3(INFINITY, 0, 0)),
                    Contains("displacement must be") && Contains("is inf"));
  CHECK_THROWS_WITH(query.closest(Vec3::Zero(), -1.0),
                    Contains("max_distance must be") && Contains("is -1"));
  CHECK_THROWS_WITH(query.closest_on({4, 0}, Vec3::Zero(), 1.0),
                    Contains("collider must be") && Contains("is 4"));
  CHECK_FALSE(SceneQuery().ray_cast({}));
}

TEST_CASE("scene_query: queries allocate nothing and may run side by side", "[collision][query]") {
  Scatter f;
  f.fixed(flat_mesh(8.0, 12), at(0, 0, -3));
  SceneQuery query(f.world, f.scene);
  const auto run = [&](std::uint64_t seed) {
    Random random(seed);
    double sum = 0.0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 from = random.vec(5.0);
      const Vec3 direction = random.vec(1.0);
      if (const auto hit = query.ray_cast({from, direction, 20.0})) sum += hit->distance;
      if (const auto hit = query.shape_cast(Capsule{0.1, 0.2}, {from, random.quat()}, direction)) {
        sum += hit->fraction;
      }
      if (const auto hit = query.closest(from, 5.0)) sum += hit->distance;
      sum += query.overlaps(Box{}, {from, random.quat()}) ? 1.0 : 0.0;
    }
    return sum;
  };
  const AllocationCount count;
  const double one = run(1);
  const double two = run(2);
  query.update(f.world, f.scene);
  CHECK(count.count() == 0);
  double first = 0.0;
  double second = 0.0;
  std::thread thread([&] { first = run(1); });
  second = run(2);
  thread.join();
  CHECK(first == one);
  CHECK(second == two);
}

TEST_CASE("scene_query: a body that moved between queries is found at its new place",
          "[collision][query]") {
  Fixture f;
  f.fixed(HalfSpace{Vec3::UnitZ(), 0.0});
  const BodyId box = f.add(Box{Vec3::Constant(0.25)}, at(0, 0, 0.25));
  f.world.set_contact_source(&f.scene);
  tandem::pbd::Solver solver;
  const auto sleep = [&] {
    for (int step = 0; step < 300 && f.world.awake(box); ++step) solver.step(f.world, kDt);
    REQUIRE_FALSE(f.world.awake(box));
  };
  SceneQuery query(f.world, f.scene);
  const auto is_at_origin = [&] {
    query.update(f.world, f.scene);
    return query.overlaps(Sphere{0.05}, at(0, 0, 0.4));
  };
  sleep();
  const auto bytes = f.world.snapshot();
  CHECK(is_at_origin());
  f.world.apply_impulse(box, Vec3(0.0, 2.0, 0.0) / f.world.props(box).inverse_mass,
                        f.world.pose(box).position);
  solver.step(f.world, kDt);
  sleep();
  REQUIRE(f.world.pose(box).position.y() > 0.3);
  CHECK_FALSE(is_at_origin());
  f.world.restore(bytes);
  CHECK(is_at_origin());
}

}  // namespace scene_query_test
