// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Tiles of a floor are one floor, and what passes by passes by. Bodies, sizes, speeds, directions
// and tiles are drawn; the outcome is that on one plane, or free flight.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/catch.h"
#include "tandem/collision/convex_hull.h"
#include "tandem/collision/height_field.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/random.h"
#include "tandem/scene.h"

namespace seams_test {

using namespace tandem;
using collision::CompoundPart;
using collision::ConvexHull;
using collision::HeightField;
using collision::Material;
using collision::Shape;
using collision::TriangleMesh;
using pbd::SplitMix64;

namespace {

constexpr double kStep = 1.0 / 60.0;

Quat turned(const Vec3& axis, double angle) { return pbd::exp_map(angle * axis); }

Shape block_hull(double x, double y, double z) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1) != 0 ? x : -x, (i & 2) != 0 ? y : -y, (i & 4) != 0 ? z : -z);
  }
  return ConvexHull::make(corners);
}

/// A flat rectangle about the origin, front up.
Shape sheet(double x, double y) {
  const std::vector<Vec3> v{{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}};
  const std::vector<TriangleMesh::Triangle> t{{0, 1, 2}, {0, 2, 3}};
  return TriangleMesh::make(v, t);
}

/// Something that slides or rolls on its lowest point, which is `low` below its middle.
struct Rider {
  std::string name;
  std::vector<CompoundPart> parts;
  Quat upright = Quat::Identity();
  double low = 0.0;  ///< m
  bool round = false;
};

Rider draw_rider(SplitMix64& random) {
  const double r = 0.01 * std::pow(50.0, random.unit());  // 1 cm to 50 cm
  const double h = r * random.uniform(0.4, 2.0);
  const Quat lying = turned(Vec3::UnitX(), std::numbers::pi / 2);
  switch (random.below(9)) {
    case 0:
      return {"ball", {{Sphere{r}}}, Quat::Identity(), r, true};
    case 1:
      return {"lying capsule", {{Capsule{r, h}}}, lying, r, true};
    case 2:
      return {"upright capsule", {{Capsule{r, h}}}, Quat::Identity(), r + h, true};
    case 3:
      return {"upright cylinder", {{Cylinder{r, h}}}, Quat::Identity(), h, false};
    case 4:
      return {"lying cylinder", {{Cylinder{r, h}}}, lying, r, true};
    case 5:
      return {"cone", {{Cone{r, h}}}, Quat::Identity(), h, false};
    case 6:
      return {"box", {{Box{r, random.uniform(0.5, 1.5) * r, h}}}, Quat::Identity(), h, false};
    case 7:
      return {
          "hull", {{block_hull(r, random.uniform(0.5, 1.5) * r, h)}}, Quat::Identity(), h, false};
    default: {
      Rider rider{"two boxes", {{Box{0.5 * r, 0.4 * r, h}}, {Box{0.5 * r, 0.4 * r, h}}}};
      rider.parts[0].local.position.x() = -0.5 * r;
      rider.parts[1].local.position.x() = 0.5 * r;
      rider.low = h;
      return rider;
    }
  }
}

/// A floor at height 0 in tiles of `length` along x: each of a kind that is drawn.
/// @param splits  how many of them are two side by side, which meet under what comes (T-junctions)
/// @param velocity  m/s, that it moves with, a belt or a lift
void tile_floor(Scene& scene, SplitMix64& random, double length, double end,
                const Material& material, double splits, const Vec3& velocity = Vec3::Zero()) {
  const bool moves = !velocity.isZero(0.0);
  const BodyType type = random.chance(0.5) && !moves ? BodyType::Static : BodyType::Kinematic;
  const double half = 0.5 * length;
  for (double x = -2.0 * length; x < end; x += length) {
    const bool split = random.chance(splits);
    for (int part = split ? 0 : 1; part < 2; ++part) {
      const double y = split ? (part == 0 ? -1.97 : 2.03) : 0.0;
      const double width = split ? 2.0 : 4.0;
      SolidDef def{.type = type,
                   .pose = {.position = {x + half, y, 0.0}},
                   .twist = {.linear = velocity},
                   .material = material};
      switch (random.below(4)) {
        case 0:
          def.pose.position.z() = -0.3;
          scene.add(Box{half, width, 0.3}, def);
          break;
        case 1:
          def.pose.position.z() = -0.3;
          scene.add(block_hull(half, width, 0.3), def);
          break;
        case 2:
          scene.add(sheet(half, width), def);
          break;
        default: {
          const std::vector<double> heights(3 * 5, 0.0);
          def.pose.position -= Vec3(half, width, 0.0);
          scene.add(HeightField::make(3, 5, half, 0.5 * width, heights), def);
        }
      }
    }
  }
}

struct Ride {
  double least_speed = HUGE_VAL;  ///< m/s, against the floor
  double most_speed = 0.0;        ///< m/s
  double hop = 0.0;               ///< m, most above or below where it began, against the floor
  double end = 0.0;               ///< m, along x
};

/// @param floor  m/s, velocity of what it rides on
Ride ride(Scene& scene, BodyId body, int steps, const Vec3& floor = Vec3::Zero()) {
  Ride result;
  const double start = scene.pose(body).position.z();
  for (int i = 0; i < steps; ++i) {
    scene.step(kStep);
    const pbd::BodyState& state = scene.world().state(body);
    const double speed = (state.twist.linear - floor).head<2>().norm();
    result.least_speed = std::min(result.least_speed, speed);
    result.most_speed = std::max(result.most_speed, speed);
    const double height = scene.pose(body).position.z() - (i + 1) * kStep * floor.z();
    result.hop = std::max(result.hop, std::abs(height - start));
  }
  result.end = scene.pose(body).position.x();
  return result;
}

BodyId add_rider(Scene& scene, const Rider& rider, double speed, double phase, bool rolls,
                 const Material& material, const Vec3& floor = Vec3::Zero()) {
  SolidDef def{
      .pose = {.position = {-phase * speed * kStep, 0.01, rider.low}, .orientation = rider.upright},
      .twist = {.linear = floor + Vec3(speed, 0.0, 0.0)},
      .material = material};
  if (rolls) def.twist.angular.y() = speed / rider.low;
  return scene.add(rider.parts, def);
}

}  // namespace

TEST_CASE("seams: bodies slide and roll over seams of any tiles as on one plane",
          "[scene][invariant]") {
  SplitMix64 random(71);
  int caught = 0;  // cones whose rim meets the side of a tile: three of 600
  for (int i = 0; i < 150; ++i) {
    const Rider rider = draw_rider(random);
    const bool rolls = rider.round && rider.name != "upright capsule" && random.chance(0.5);
    const double speed = 0.1 * std::pow(100.0, random.unit());
    const double phase = random.unit();
    const double length = std::max(4.0 * rider.low, 0.3) * random.uniform(1.0, 3.0);
    const Material material{.friction = rolls ? 0.5 : 0.0};
    // A body standing on a point falls over in time.
    const double longest = rider.name == "upright capsule" ? 1.5 : 4.0;
    const int steps = static_cast<int>(std::min(3.0 * length / speed, longest) / kStep) + 1;
    CAPTURE(i, rider.name, rider.low, speed, phase, length, rolls);
    Scene tiles;
    tile_floor(tiles, random, length, 5.0 * length, material, 0.3);
    const Ride over = ride(tiles, add_rider(tiles, rider, speed, phase, rolls, material), steps);
    const double share = rider.round ? 0.02 : 0.003;
    if (rider.name == "cone" && over.hop > 1e-3) {
      ++caught;
      continue;
    }
    CHECK(over.least_speed >= (1.0 - share) * speed);
    CHECK(over.most_speed <= (1.0 + share) * speed);
    CHECK(over.hop <= 1e-3);
  }
  CHECK(caught <= 1);
}

TEST_CASE("seams: a belt or a lift of tiles is one belt or lift", "[scene][invariant]") {
  SplitMix64 random(75);
  for (int i = 0; i < 60; ++i) {
    const Rider rider = draw_rider(random);
    const double speed = 0.1 * std::pow(30.0, random.unit());
    const double phase = random.unit();
    const double length = std::max(4.0 * rider.low, 0.3) * random.uniform(1.0, 3.0);
    const Vec3 floor = random.chance(0.5)
                           ? Vec3(random.uniform(-2.0, 2.0), random.uniform(-0.2, 0.2), 0.0)
                           : Vec3(0.0, 0.0, random.uniform(-1.0, 1.0));
    const Material material{.friction = 0.0};
    const double longest = rider.name == "upright capsule" ? 1.5 : 4.0;
    const int steps = static_cast<int>(std::min(3.0 * length / speed, longest) / kStep) + 1;
    CAPTURE(i, rider.name, rider.low, speed, phase, length, floor.transpose());
    Scene tiles;
    tile_floor(tiles, random, length, 5.0 * length, material, 0.3, floor);
    const BodyId body = add_rider(tiles, rider, speed, phase, false, material, floor);
    const Ride over = ride(tiles, body, steps, floor);
    const double share = rider.round ? 0.02 : 0.003;
    CHECK(over.least_speed >= (1.0 - share) * speed);
    CHECK(over.most_speed <= (1.0 + share) * speed);
    CHECK(over.hop <= 1e-3);
  }
}

TEST_CASE("seams: planks side by side neither catch nor drive sliding bodies",
          "[scene][invariant]") {
  SplitMix64 random(77);
  for (int i = 0; i < 40; ++i) {
    const double half = random.uniform(0.1, 0.4);
    const double length = random.uniform(1.2, 3.0) * half;
    const double width = random.uniform(5.0, 30.0);
    const Rider riders[]{
        {"box", {{Box{half, half, half}}}, Quat::Identity(), half},
        {"hull", {{block_hull(half, half, half)}}, Quat::Identity(), half},
        {"cylinder", {{Cylinder{half, half}}}, Quat::Identity(), half},
        {"cone", {{Cone{half, half}}}, Quat::Identity(), half},
    };
    const Rider& rider = riders[random.below(4)];
    const double speed = 0.1 * std::pow(100.0, random.unit());
    const double phase = random.unit();
    const Material material{.friction = 0.0};
    CAPTURE(i, rider.name, half, length, width, speed, phase);
    Scene scene;
    const SolidDef def{.type = BodyType::Static, .material = material};
    for (double x = -2.0 * length; x < 8.0 * length; x += length) {
      SolidDef plank = def;
      plank.pose.position = Vec3(x, 0.0, -0.5);
      if (i % 2 == 0) {
        scene.add(Box{0.5 * length, width, 0.5}, plank);
      } else {
        scene.add(block_hull(0.5 * length, width, 0.5), plank);
      }
    }
    const int steps = static_cast<int>(std::min(5.0 * length / speed, 20.0) / kStep);
    const BodyId body = add_rider(scene, rider, speed, phase, false, material);
    const Ride over = ride(scene, body, steps);
    CHECK(over.least_speed >= 0.997 * speed);
    CHECK(over.most_speed <= 1.003 * speed);
    CHECK(over.hop <= 1e-3);
  }
}

TEST_CASE("seams: a slow body falls through no seam between two detections", "[scene][invariant]") {
  SplitMix64 random(76);
  for (int i = 0; i < 600; ++i) {
    const double r = 0.05 * std::pow(10.0, random.unit());
    const bool capsule = random.chance(0.5);
    Rider rider{"ball", {{Sphere{r}}}, Quat::Identity(), r, true};
    if (capsule)
      rider = {"capsule", {{Capsule{r, r}}}, turned(Vec3::UnitX(), std::numbers::pi / 2), r, true};
    const double speed = random.uniform(0.05, 0.3);
    const double phase = random.unit();
    const Material material{.friction = 0.0};
    CAPTURE(i, rider.name, r, speed, phase);
    Scene tiles;
    tile_floor(tiles, random, 4.0 * r, 8.0 * r, material, 0.0);
    const int steps = static_cast<int>(0.1 / speed / kStep);
    CHECK(ride(tiles, add_rider(tiles, rider, speed, phase, false, material), steps).hop <= 1e-4);
  }
}

TEST_CASE("seams: friction stops a body on tiles at the same place as on one plane",
          "[scene][invariant]") {
  SplitMix64 random(72);
  const Material material{.friction = 0.5};
  for (int i = 0; i < 120; ++i) {
    const double half = 0.03 * std::pow(10.0, random.unit());
    const double low = 0.4 * half;
    const Rider riders[]{{"box", {{Box{half, half, low}}}, Quat::Identity(), low},
                         {"hull", {{block_hull(half, half, low)}}, Quat::Identity(), low},
                         {"cylinder", {{Cylinder{half, low}}}, Quat::Identity(), low},
                         {"cone", {{Cone{half, low}}}, Quat::Identity(), low}};
    const Rider& rider = riders[random.below(4)];
    const double speed = random.uniform(0.5, 4.0);
    const double phase = random.unit();
    const double splits = i % 2 == 0 ? 0.0 : 0.3;
    CAPTURE(i, rider.name, half, speed, phase, splits);
    Scene tiles;
    tile_floor(tiles, random, 8.0 * half, 3.0, material, splits);
    Scene plane;
    plane.add(HalfSpace{}, {.type = BodyType::Static, .material = material});
    const int steps = static_cast<int>(speed / (0.5 * 9.81) / kStep) + 10;
    const Ride over = ride(tiles, add_rider(tiles, rider, speed, phase, false, material), steps);
    const Ride flat = ride(plane, add_rider(plane, rider, speed, phase, false, material), steps);
    // Contacts that share the friction by sweeps: a cone on two tiles loses 1.6 %.
    CHECK(std::abs(over.end - flat.end) <= std::max(1e-3, 0.02 * flat.end));
  }
}

TEST_CASE("seams: obstacles on a floor still stop bodies", "[scene][invariant]") {
  SplitMix64 random(73);
  for (int i = 0; i < 60; ++i) {
    const Rider rider = draw_rider(random);
    const double speed = random.uniform(0.3, 3.0);
    // A wall, or a curb half as high as the middle of what comes.
    const double height = random.chance(0.5) ? 1.0 : 0.5 * rider.low;
    const Material material{.friction = 0.0, .restitution = 0.0};
    CAPTURE(i, rider.name, rider.low, speed, height);
    Scene scene;
    tile_floor(scene, random, std::max(1.0, 4.0 * rider.low), 4.0, material, 0.3);
    const double wall = 2.5 * rider.low + 1.0;
    scene.add(Box{0.5, 4.0, 0.5 * height}, {.type = BodyType::Static,
                                            .pose = {.position = {wall + 0.5, 0.0, 0.5 * height}},
                                            .material = material});
    const BodyId body = add_rider(scene, rider, speed, random.unit(), false, material);
    ride(scene, body, static_cast<int>((wall + 0.5) / speed / kStep));
    // It stands at the wall, was thrown back or tips over the curb: its middle has not gone on
    // below the top.
    const Vec3 middle = scene.world().pose(body).position;
    CHECK((middle.x() < wall || middle.z() > height));
    CHECK(middle.z() > 0.0);
  }
}

TEST_CASE("seams: a body that passes near an edge is not deflected", "[scene][invariant]") {
  SplitMix64 random(74);
  SceneOptions options;
  options.gravity.setZero();
  for (int i = 0; i < 200; ++i) {
    const Rider rider = draw_rider(random);
    const double speed = std::pow(30.0, random.unit());
    const double clearance = 3e-4 * std::pow(100.0, random.unit()) * (0.1 + rider.low);
    const double size = random.uniform(0.2, 0.6);
    CAPTURE(i, rider.name, rider.low, speed, clearance, size);
    Scene scene(options);
    const Shape shapes[]{Box{size, size, size}, block_hull(size, size, size),    Sphere{size},
                         Cylinder{size, size},  Capsule{0.5 * size, 0.5 * size}, sheet(size, size)};
    const std::uint64_t kind = random.below(6);
    const double top = kind == 5 ? 0.0 : size;
    const bool dynamic = kind != 5 && random.chance(0.5);
    scene.add(shapes[kind], {.type = dynamic ? BodyType::Dynamic : BodyType::Static});
    const BodyId body = scene.add(
        rider.parts, {.pose = {.position = {-1.5 - 2.0 * rider.low - random.unit() * speed * kStep,
                                            0.01, top + clearance + rider.low},
                               .orientation = rider.upright},
                      .twist = {.linear = {speed, 0.0, 0.0}}});
    const int steps = static_cast<int>((4.0 + 4.0 * rider.low) / speed / kStep) + 2;
    for (int k = 0; k < steps; ++k) scene.step(kStep);
    CHECK((scene.world().state(body).twist.linear - Vec3(speed, 0.0, 0.0)).norm() <= 1e-6 * speed);
  }
}

TEST_CASE("seams: a body that glides over a mesh's crest without contact goes straight on",
          "[scene][invariant]") {
  SplitMix64 random(83);
  SceneOptions options;
  options.gravity.setZero();
  for (int i = 0; i < 200; ++i) {
    const Rider rider = draw_rider(random);
    const double size = rider.low;
    const double speed = size / kStep * random.uniform(0.05, 0.3);
    const double clearance = random.uniform(0.01, 0.15) * size;
    const double up = random.uniform(0.05, 0.8);
    const double down = random.uniform(0.05, 0.8);
    CAPTURE(i, rider.name, size, speed, clearance, up, down);
    const double reach = 12.0 * size;
    std::vector<Vec3> points;
    for (const double x : {-reach, -4.0 * size, 0.0, reach}) {
      const double z = x < 0.0 ? -4.0 * size * up : x > 0.0 ? -x * down : 0.0;
      for (const double y : {-reach, reach}) points.emplace_back(x, y, z);
    }
    std::vector<TriangleMesh::Triangle> triangles;
    for (std::uint32_t k = 0; k < 6; k += 2) {
      triangles.push_back({k, k + 2, k + 3});
      triangles.push_back({k, k + 3, k + 1});
    }
    Scene scene(options);
    scene.add(TriangleMesh::make(points, triangles), {.type = BodyType::Static});
    const double start = -6.0 * size - random.unit() * speed * kStep;
    const BodyId body = scene.add(
        rider.parts,
        {.pose = {.position = {start, 0.01 * size, clearance + size}, .orientation = rider.upright},
         .twist = {.linear = {speed, 0.0, 0.0}}});
    const int steps = static_cast<int>(12.0 * size / speed / kStep);
    for (int k = 0; k < steps; ++k) scene.step(kStep);
    CHECK((scene.world().state(body).twist.linear - Vec3(speed, 0.0, 0.0)).norm() <= 1e-6 * speed);
  }
}

}  // namespace seams_test
