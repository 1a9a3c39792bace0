// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/cloth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "../collision/allocation_count.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/world_copy.h"

namespace cloth_test {

using namespace tandem;
using collision::testing::AllocationCount;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kStep = 1.0 / 60.0;
const Quat kUpright(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()));  // y becomes up

void steps(Scene& scene, int count) {
  for (int i = 0; i < count; ++i) REQUIRE(scene.step(kStep).status == pbd::StepStatus::Ok);
}

BodyId post(Scene& scene) {
  return scene.add(Box{0.01, 0.01, 0.01}, {.type = BodyType::Static, .filter = {.mask = 0}});
}

void attach_edges(Scene& scene, Cloth& cloth, bool all) {
  const BodyId frame = post(scene);
  for (int row = 0; row < cloth.rows(); ++row) {
    cloth.attach(0, row, frame);
    cloth.attach(cloth.columns() - 1, row, frame);
  }
  for (int column = 1; all && column + 1 < cloth.columns(); ++column) {
    cloth.attach(column, 0, frame);
    cloth.attach(column, cloth.rows() - 1, frame);
  }
}

/// Hung by two edges that are closer than it is wide.
Cloth drape(Scene& scene, int columns, int rows, double apart) {
  Cloth cloth(scene, {.pose = {.position = Vec3(0.0, 0.0, 3.0)},
                      .width = 1.5,
                      .height = 0.6,
                      .columns = columns,
                      .rows = rows,
                      .bending = 1e-6,
                      .damping = 2.0});
  const BodyId right = scene.add(Box{0.01, 0.01, 0.01}, {.type = BodyType::Kinematic,
                                                         .pose = {.position = Vec3(1.5, 0.0, 3.0)},
                                                         .filter = {.mask = 0}});
  const BodyId left = post(scene);
  for (int row = 0; row < rows; ++row) {
    cloth.attach(0, row, left);
    cloth.attach(columns - 1, row, right);
  }
  for (int i = 1; i <= 60; ++i) {
    const double x = 1.5 - (1.5 - apart) * i / 60.0;
    scene.world().set_kinematic_target(right, {.position = Vec3(x, 0.0, 3.0)});
    steps(scene, 1);
  }
  steps(scene, 15 * 60);
  return cloth;
}

TEST_CASE("cloth: between two edges each thread hangs as a catenary, at any resolution",
          "[scene][analytic]") {
  double low = 0.05, high = 50.0;
  for (int i = 0; i < 100; ++i) {
    const double a = 0.5 * (low + high);
    (2.0 * a * std::sinh(0.5 / a) > 1.5 ? low : high) = a;
  }
  const double sag = low * (std::cosh(0.5 / low) - 1.0);
  for (const int columns : {21, 31}) {
    Scene scene;
    const Cloth cloth = drape(scene, columns, 8, 1.0);
    double worst = 0.0;
    for (const BodyId id : cloth.particles()) {
      const Vec3& at = scene.world().pose(id).position;
      const double curve = 3.0 - sag + low * (std::cosh((at.x() - 0.5) / low) - 1.0);
      worst = std::max(worst, std::abs(at.z() - curve));
    }
    CAPTURE(columns, sag);
    CHECK(worst < 0.01 * sag);
  }
}

TEST_CASE("cloth: one that does not spring back never has more energy than before",
          "[scene][invariant]") {
  // Diagonals and bending are springs: with them energy is only below what it was at the start.
  for (const double springs : {0.0, 1.0}) {
    Scene scene({.solver = {.sleep_after = 0.0}});
    Cloth cloth(scene, {.pose = {.position = Vec3(0.0, 0.0, 2.0)},
                        .columns = 16,
                        .rows = 16,
                        .shearing = 50.0 * springs,
                        .bending = 1e-4 * springs,
                        .damping = 0.0});
    const BodyId corner = post(scene);
    cloth.attach(0, 0, corner);
    cloth.attach(15, 0, corner);
    const double start = scene.world().mechanical_energy();
    double before = start, rise = 0.0, top = -1.0;
    for (int i = 0; i < 240; ++i) {
      steps(scene, 1);
      const double now = scene.world().mechanical_energy();
      rise = std::max(rise, now - before);
      top = std::max(top, now - start);
      before = now;
    }
    CAPTURE(springs);
    CHECK(top <= 1e-9);
    if (springs == 0.0) CHECK(rise < 1e-3 * start);
    CHECK(before < 0.9 * start);  // it fell
  }
}

TEST_CASE("cloth: at 10 m/s no part of it gets through a ball", "[scene][contact]") {
  Scene scene({.gravity = Vec3::Zero()});
  scene.add(Sphere{0.2}, {.type = BodyType::Static});
  Cloth cloth(scene, {.pose = {.position = Vec3(-0.5, -0.5, 0.4)}, .columns = 21, .rows = 21});
  for (const BodyId id : cloth.particles()) {
    scene.world().set_twist(id, {.linear = Vec3(0.0, 0.0, -10.0)});
  }
  double deepest = 0.0;
  for (int i = 0; i < 60; ++i) {
    steps(scene, 1);
    for (const BodyId id : cloth.particles()) {
      deepest = std::max(deepest, 0.21 - scene.world().pose(id).position.norm());
    }
  }
  CHECK(deepest < 0.01);  // its own radius
}

// A body heavier than the sheet parts its threads and gets through: docs/parts.md.
TEST_CASE(
    "cloth: a ball at 10 m/s of half its mass comes back, wherever it hits; none gains energy",
    "[scene][contact][long]") {
  struct Throw {
    double mass, density;
    double x, z;  ///< m, beside a particle
  };
  std::vector<Throw> throws{
      {0.5, 0.2, 0.0, 0.0}, {2.0, 0.2, 0.0, 0.0}, {2.0, 1.0, 0.0, 0.0}, {10.0, 1.0, 0.0, 0.0}};
  for (const double x : {0.0, 0.007, 0.014, 0.021}) {
    for (const double z : {0.0, 0.007, 0.014, 0.021}) {
      throws.push_back({0.1, 0.2, x, z});
      throws.push_back({0.5, 1.0, x, z});
    }
  }
  for (const auto& [mass, density, x, z] : throws) {
    Scene scene;
    Cloth cloth(
        scene,
        {.pose = {Vec3(-0.5, 0.0, 1.0), kUpright}, .columns = 21, .rows = 21, .density = density});
    attach_edges(scene, cloth, true);
    const BodyId ball = scene.add(Sphere{0.12}, {.mass = mass,
                                                 .pose = {.position = Vec3(x, -1.0, 1.6 + z)},
                                                 .twist = {.linear = Vec3(0.0, 10.0, 0.0)}});
    const double start = scene.world().mechanical_energy();
    double top = -1.0, through = -1.0;
    for (int i = 0; i < 60; ++i) {
      steps(scene, 1);
      top = std::max(top, scene.world().mechanical_energy() - start);
      through = std::max(through, scene.world().pose(ball).position.y());
    }
    CAPTURE(mass, density, x, z, through);
    CHECK(top < 1e-9);
    if (mass <= 0.5 * density) CHECK(scene.world().pose(ball).position.y() < 0.0);  // it came back
  }
}

TEST_CASE("cloth: a snapshot and a copy go on with the same bits, on any number of threads",
          "[scene][determinism]") {
  const auto run = [](int threads, int count, Scene& scene) {
    scene.add(Sphere{0.2}, {.type = BodyType::Static, .pose = {.position = Vec3(0.0, 0.0, 0.5)}});
    Cloth cloth(scene, {.pose = {.position = Vec3(-0.5, -0.5, 1.0)}, .columns = 12, .rows = 12});
    const BodyId weight =
        scene.add(Box{0.05, 0.05, 0.05}, {.pose = {.position = Vec3(0.5, 0.5, 0.9)}});
    cloth.attach(11, 11, weight);
    cloth.tether();
    cloth.add_handle(0.3, 0.4, 0.2, 0.5);
    CHECK(scene.solver().options().threads == threads);
    steps(scene, count);
  };
  Scene one;
  run(1, 60, one);
  Scene four({.solver = {.threads = 4}});
  run(4, 60, four);
  CHECK(one.world().hash() == four.world().hash());
  const auto bytes = one.world().snapshot();
  pbd::WorldCopy copy;
  REQUIRE(copy.assign(one.world()));
  steps(one, 60);
  four.world().restore(bytes);
  steps(four, 60);
  CHECK(one.world().hash() == four.world().hash());
  pbd::Solver solver;
  for (int i = 0; i < 60; ++i) solver.step(copy.world(), kStep);
  CHECK(one.world().hash() == copy.world().hash());
}

TEST_CASE("cloth: allocates nothing once it hangs", "[scene][allocation]") {
  Scene scene({.solver = {.sleep_after = 0.0}});
  Cloth cloth(scene, {.pose = {.position = Vec3(-0.5, -0.5, 1.0)}, .columns = 10, .rows = 10});
  attach_edges(scene, cloth, false);
  cloth.tether();
  steps(scene, 120);
  const AllocationCount allocations;
  for (int i = 0; i < 60; ++i) scene.step(kStep);
  CHECK(allocations.count() == 0);
}

TEST_CASE("cloth: a handle is the mean about its place, with mass from there, and pulls it",
          "[scene][analytic]") {
  Scene scene({.gravity = Vec3::Zero()});
  Cloth cloth(scene, {.columns = 21, .rows = 11});
  CHECK((cloth.point(0.3, 0.7) - Vec3(0.3, 0.7, 0.0)).norm() < 1e-14);
  const BodyId handle = cloth.add_handle(0.3, 0.7, 0.3, 0.9);
  CHECK((scene.pose(handle).position - Vec3(0.3, 0.7, 0.0)).norm() < 1e-14);
  // Mass under a hat function over a square of twice its reach.
  CHECK(scene.world().props(handle).mass == Approx(0.9 * 0.2 * 0.3 * 0.3));
  scene.world().apply_impulse(handle, Vec3(0.0, 0.0, 0.02));
  steps(scene, 60);
  Vec3 mean = Vec3::Zero();
  double weights = 0.0, mass = scene.world().props(handle).mass;
  double momentum = mass * scene.world().twist(handle).linear.z();
  for (int row = 0; row < 11; ++row) {
    for (int column = 0; column < 21; ++column) {
      const BodyId id = cloth.particle(column, row);
      const double x = std::abs(0.05 * column - 0.3), y = std::abs(0.1 * row - 0.7);
      const double edge = column == 0 || column == 20 || row == 0 || row == 10 ? 0.5 : 1.0;
      const double weight = edge * std::max(0.0, 0.3 - x) * std::max(0.0, 0.3 - y);
      mean += weight * scene.pose(id).position;
      weights += weight;
      mass += scene.world().props(id).mass;
      momentum += scene.world().props(id).mass * scene.world().twist(id).linear.z();
    }
  }
  CHECK((scene.pose(handle).position - mean / weights).norm() < 1e-4);
  // All of the momentum is in the cloth, but for what the air took.
  CHECK(mass == Approx(0.2));
  CHECK(momentum == Approx(0.02 * std::exp(-0.2)).epsilon(0.01));
  // Mass taken by one is not taken by another.
  CHECK(names(refusal([&] { cloth.add_handle(0.3, 0.7, 0.3, 0.5); }), "share", "0.5", "have left"));
  CHECK(names(refusal([&] { cloth.add_handle(0.3, 1.7, 0.3, 0.5); }), "v", "1.7", "from 0 to 1"));
  CHECK(names(refusal([&] { cloth.add_handle(0.3, 0.7, 0.1, 0.5); }), "reach", "0.1", "above"));
}

TEST_CASE("cloth: tethers keep hanging cloth from stretching", "[scene][invariant]") {
  double hangs[2] = {};
  for (const bool tethered : {false, true}) {
    Scene scene;
    Cloth cloth(
        scene,
        {.pose = {Vec3(0.0, 0.0, 1.0), kUpright}, .columns = 10, .rows = 10, .stretching = 20.0});
    const BodyId rail = post(scene);
    for (int column = 0; column < 10; ++column) cloth.attach(column, 9, rail);
    if (tethered) cloth.tether();
    steps(scene, 240);
    hangs[tethered ? 1 : 0] = 2.0 - cloth.point(0.5, 0.0).z();
  }
  CHECK(hangs[0] > 1.02);
  CHECK(hangs[1] < 1.002);
}

TEST_CASE("cloth: invalid definitions are refused by name", "[scene][input]") {
  Scene scene;
  const auto refused = [&](const ClothDef& def) { return refusal([&] { Cloth(scene, def); }); };
  CHECK(names(refused({.pose = {.orientation = Quat(1.0, 0.0, 0.0, 1.0)}}), "pose.orientation",
              "1.41", "unit norm"));
  CHECK(names(refused({.width = 0.0}), "width", "0", "> 0"));
  CHECK(names(refused({.height = -1.0}), "height", "-1", "> 0"));
  CHECK(names(refused({.columns = 1}), "columns", "1", "from 2"));
  CHECK(names(refused({.rows = 1}), "rows", "1", "from 2"));
  CHECK(names(refused({.density = 0.0}), "density", "0", "> 0"));
  CHECK(names(refused({.stretching = -1.0}), "stretching", "-1", ">= 0"));
  CHECK(names(refused({.shearing = -1.0}), "shearing", "-1", ">= 0"));
  CHECK(names(refused({.bending = NAN}), "bending", "nan", ">= 0"));
  CHECK(scene.world().body_count() == 0);
  Cloth cloth(scene, {.columns = 3, .rows = 3});
  CHECK(names(refusal([&] { cloth.particle(3, 0); }), "column", "3", "below columns"));
  CHECK(names(refusal([&] { cloth.point(0.0, 1.5); }), "v", "1.5", "from 0 to 1"));
}

}  // namespace cloth_test
