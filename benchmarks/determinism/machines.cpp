// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <array>
#include <vector>

#include "benchmarks/scenes/random.h"
#include "determinism/case.h"
#include "tandem/collision/convex_hull.h"
#include "tandem/collision/height_field.h"
#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/portable.h"

namespace tandem::determinism {
namespace {

Pose at(double x, double y, double z) { return {.position = Vec3(x, y, z)}; }

/// A wavy square of triangles, 8 m wide, from x on.
collision::Shape waves(double from) {
  constexpr std::uint32_t kCells = 24;
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t j = 0; j <= kCells; ++j) {
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      const double x = 8.0 * i / kCells;
      const double y = 8.0 * j / kCells - 4.0;
      vertices.emplace_back(from + x, y, 0.3 * pbd::portable::sin_cos(x + 2.0 * y).sin);
      if (i == kCells || j == kCells) continue;
      const std::uint32_t corner = j * (kCells + 1) + i;
      triangles.push_back({corner, corner + 1, corner + kCells + 2});
      triangles.push_back({corner, corner + kCells + 2, corner + kCells + 1});
    }
  }
  return collision::TriangleMesh::make(vertices, triangles);
}

/// The same as a height field, in its own frame from its corner.
collision::Shape field() {
  constexpr std::uint32_t kPosts = 25;
  std::vector<double> heights;
  for (std::uint32_t i = 0; i < kPosts * kPosts; ++i) {
    heights.push_back(0.2 * pbd::portable::sin_cos(0.37 * i).cos);
  }
  return collision::HeightField::make(kPosts, kPosts, 8.0 / (kPosts - 1), 8.0 / (kPosts - 1),
                                      heights);
}

collision::Shape hull() {
  return collision::ConvexHull::make(std::vector<Vec3>{{0.3, 0.0, 0.0},
                                                       {-0.2, 0.25, 0.0},
                                                       {-0.2, -0.25, 0.0},
                                                       {0.0, 0.1, 0.35},
                                                       {0.05, -0.1, -0.3}});
}

}  // namespace

void build_machine(Scene& scene) {
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId none;
  for (int i = 0; i < 8; ++i) {
    const double y = 0.8 * i - 2.8;
    const auto bar = [&](double x) {
      return scene.add(
          Box{0.25, 0.05, 0.03},
          {.pose = at(x, y, 2.0), .linear_damping = 0.02 * i, .angular_damping = 0.1 * i});
    };
    const BodyId first = bar(0.3), second = bar(0.9), third = bar(1.5);
    pbd::HingeJointDef hinge =
        pbd::hinge_joint_at(scene.world(), none, first, Vec3(0.0, y, 2.0), Vec3(0.2, 1.0, 0.1 * i));
    if (i % 2 == 1)
      hinge.axis.motor = {.mode = pbd::MotorMode::Velocity, .target = 3.0 + i, .max_force = 60.0};
    if (i % 4 == 2) hinge.axis = {.freedom = pbd::Freedom::Limited, .lower = -0.5, .upper = 0.7};
    scene.add_joint(hinge);
    pbd::BallJointDef ball = pbd::ball_joint_at(scene.world(), first, second, Vec3(0.6, y, 2.0));
    ball.cone = 0.6;
    ball.limit_twist = true;
    ball.lower_twist = -0.4;
    ball.upper_twist = 0.4;
    ball.break_force = i == 5 ? 150.0 : 0.0;
    scene.add_joint(ball);
    pbd::SliderJointDef slider =
        pbd::slider_joint_at(scene.world(), second, third, Vec3(1.2, y, 2.0), Vec3::UnitX());
    slider.axis = {.freedom = pbd::Freedom::Limited,
                   .lower = -0.2,
                   .upper = 0.3,
                   .spring = {.stiffness = 200.0, .damping = 2.0}};
    scene.add_joint(slider);
  }
}

void build_shapes(Scene& scene) {
  scene.add(waves(0.0), {.type = BodyType::Static});
  scene.add(field(), {.type = BodyType::Static, .pose = at(-8.0, -4.0, 0.0)});
  const std::vector<collision::CompoundPart> table{
      {.shape = Box{0.3, 0.3, 0.04}},
      {.shape = Cylinder{0.05, 0.2}, .local = at(0.2, 0.1, -0.2)},
      {.shape = Sphere{0.12}, .local = at(-0.2, 0.0, 0.2)}};
  const std::vector<collision::Shape> shapes{Sphere{0.25},        Box{0.25, 0.2, 0.15},
                                             Capsule{0.15, 0.25}, Cylinder{0.2, 0.25},
                                             Cone{0.25, 0.3},     hull()};
  bench::SceneRandom random;
  for (int i = 0; i < 84; ++i) {
    // In separate statements: compilers differ in the evaluation order of arguments.
    const double x = 12.0 * random.u() - 6.0;
    const double y = 5.0 * random.u() - 2.5;
    SolidDef def{.pose = at(x, y, 1.0 + 0.1 * i),
                 .material = {.friction = 0.2 + 0.1 * (i % 5), .restitution = 0.2 * (i % 3)},
                 .bullet = i % 12 == 0};
    def.pose.orientation = random.orientation(3.14159);
    const auto kind = static_cast<std::size_t>(i) % (shapes.size() + 1);
    if (kind < shapes.size()) {
      scene.add(shapes[kind], def);
    } else {
      scene.add(table, def);
    }
  }
}

}  // namespace tandem::determinism
