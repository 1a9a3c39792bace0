// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/debug_draw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/targets.h"
#include "tandem/scene.h"

namespace debug_draw_test {

using namespace tandem;

struct Lines : DebugDraw {
  struct Line {
    Vec3 from, to;
    DebugKind kind;
  };
  void line(const Vec3& from, const Vec3& to, DebugKind kind) override {
    lines.push_back({from, to, kind});
  }
  std::vector<Line> of(DebugKind kind) const {
    std::vector<Line> found;
    std::ranges::copy_if(lines, std::back_inserter(found),
                         [&](const Line& line) { return line.kind == kind; });
    return found;
  }
  std::vector<Line> lines;
};

Lines drawn(Scene& scene, const DebugDrawOptions& options = {}) {
  Lines lines;
  debug_draw(scene.world(), &scene.shapes(), lines, options);
  return lines;
}

TEST_CASE("debug draw: a resting box, with its contacts and their loads", "[scene][draw]") {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId box =
      scene.add(Box{0.5, 0.4, 0.3}, {.mass = 20.0, .pose = {.position = {1.0, 2.0, 0.3}}});
  for (int i = 0; i < 30; ++i) scene.step(1.0 / 60.0);
  const Lines lines = drawn(scene, {.force_scale = 0.01});
  CHECK(lines.of(DebugKind::Static).size() == 5);
  const auto edges = lines.of(DebugKind::Awake);
  REQUIRE(edges.size() == 12);
  for (const auto& edge : edges) {
    for (const Vec3& end : {edge.from, edge.to}) {
      CHECK(((end - scene.pose(box).position).cwiseAbs() - Vec3(0.5, 0.4, 0.3)).norm() < 1e-6);
    }
    CHECK((edge.from - edge.to).norm() > 0.5);
  }
  const auto normals = lines.of(DebugKind::Contact);
  CHECK(normals.size() == 4);
  for (const auto& normal : normals) {
    CHECK(std::abs(normal.from.z()) < 2e-3);
    CHECK(std::abs((normal.to - normal.from).z()) == Approx(0.1));
  }
  double force = 0.0;
  for (const auto& line : lines.of(DebugKind::Force)) force += (line.to - line.from).norm() / 0.01;
  CHECK(force == Approx(20.0 * 9.81).epsilon(0.01));  // they bear its weight
  CHECK(lines.of(DebugKind::Joint).empty());
  CHECK(lines.of(DebugKind::Correction).empty());

  for (int i = 0; i < 300; ++i) scene.step(1.0 / 60.0);
  CHECK(drawn(scene).of(DebugKind::Asleep).size() == 12);
  CHECK(drawn(scene, {.shapes = false, .contacts = false}).lines.empty());
  Lines no_shapes;
  debug_draw(scene.world(), nullptr, no_shapes, {.contacts = false});
  CHECK(no_shapes.lines.empty());
}

TEST_CASE("debug draw: round shapes lie on their surfaces", "[scene][draw]") {
  Scene scene;
  const Vec3 at(3.0, -1.0, 2.0);
  const SolidDef def{.type = BodyType::Kinematic, .pose = {.position = at}};
  SECTION("sphere") {
    scene.add(Sphere{0.7}, def);
    const auto lines = drawn(scene).of(DebugKind::Kinematic);
    CHECK(lines.size() == 72);
    for (const auto& line : lines) CHECK((line.from - at).norm() == Approx(0.7));
  }
  SECTION("capsule") {
    scene.add(Capsule{0.2, 0.5}, def);
    const auto lines = drawn(scene).of(DebugKind::Kinematic);
    CHECK(lines.size() == 48 + 4 + 48);
    for (const auto& line : lines) {
      const Vec3 p = line.from - at;
      const Vec3 core(0.0, 0.0, std::clamp(p.z(), -0.5, 0.5));
      CHECK((p - core).norm() == Approx(0.2));
    }
  }
  SECTION("cylinder and cone") {
    scene.add(Cylinder{0.2, 0.5}, def);
    CHECK(drawn(scene).lines.size() == 52);
    scene.add(Cone{0.2, 0.5}, def);
    CHECK(drawn(scene).lines.size() == 52 + 28);
  }
  SECTION("hull") {
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
    scene.add(collision::ConvexHull::make(corners), def);
    CHECK(drawn(scene).lines.size() == 12);
  }
  SECTION("mesh") {
    const std::array<Vec3, 4> corners{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    const std::array<collision::TriangleMesh::Triangle, 4> faces{
        {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    scene.add(collision::TriangleMesh::make(corners, faces), def);
    CHECK(drawn(scene).lines.size() == 12);
  }
  SECTION("field and sensor") {
    const std::array<double, 6> heights{};
    SolidDef fixed = def;
    fixed.type = BodyType::Static;
    scene.add(collision::HeightField::make(3, 2, 1.0, 1.0, heights), fixed);
    CHECK(drawn(scene).of(DebugKind::Static).size() == 12);
    fixed.sensor = true;
    scene.add(Box{1.0, 1.0, 1.0}, fixed);
    CHECK(drawn(scene).of(DebugKind::Sensor).size() == 12);
  }
}

TEST_CASE("debug draw: joints between bodies, and agreement's corrections", "[scene][draw]") {
  Scene scene({.gravity = Vec3::Zero()});
  const BodyId a = scene.add(Sphere{0.1}, {.pose = {.position = {0.0, 0.0, 1.0}}});
  const BodyId b = scene.add(Sphere{0.1}, {.pose = {.position = {0.0, 2.0, 1.0}}});
  scene.add_joint(pbd::ball_joint_at(scene.world(), a, b, Vec3(0.0, 1.0, 1.0)));
  const auto joints = drawn(scene).of(DebugKind::Joint);
  REQUIRE(joints.size() == 1);
  CHECK((joints[0].to - joints[0].from).norm() == Approx(2.0));
  tandem::testing::FixedTargets targets;
  targets.targets = {{.body = a, .pose = {Vec3(0.5, 0.0, 1.0), Quat::Identity()}, .share = 0.5}};
  scene.world().set_target_source(&targets);
  const Vec3 before = scene.pose(a).position;
  scene.step(1.0 / 60.0);
  const auto moved = drawn(scene).of(DebugKind::Correction);
  REQUIRE_FALSE(moved.empty());
  CHECK((moved[0].from - before).norm() < 1e-9);
  CHECK(moved[0].to == scene.pose(a).position);
  CHECK((moved[0].to - before).norm() > 0.05);
  const Lines without = drawn(scene, {.joints = false, .corrections = false});
  CHECK(without.of(DebugKind::Joint).empty());
  CHECK(without.of(DebugKind::Correction).empty());
  CHECK(without.of(DebugKind::Awake).size() == 144);
}

}  // namespace debug_draw_test
