// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E1: a body that slides or rolls over the flush seam of two bodies moves as on one.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "everyday/any_world.h"
#include "everyday/ground.h"
#include "everyday/group.h"

namespace tandem::everyday {
namespace {

constexpr double kSize = 0.25;  // m, half size of the moving body

struct Mover {
  std::string name;
  bool flat;  ///< has a face on the ground
  bool rolls;
  std::vector<collision::CompoundPart> parts;
  double height = kSize;  ///< m, of the shape's origin on the ground
  Quat turn = Quat::Identity();
};

std::vector<Vec3> box_corners(const Vec3& half) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                         (i & 4) != 0 ? half.z() : -half.z());
  }
  return corners;
}

std::vector<Mover> movers() {
  const Vec3 half = Vec3::Constant(kSize);
  const Quat lying(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vec3::UnitX()));
  const Vec3 slim(kSize, 0.5 * kSize, kSize);
  return {
      {"sphere slides", false, false, {{.shape = Sphere{kSize}}}},
      {"sphere rolls", false, true, {{.shape = Sphere{kSize}}}},
      {"ball of 2 cm rolls", false, true, {{.shape = Sphere{0.02}}}, 0.02},
      {"lying capsule slides", false, false, {{.shape = Capsule{kSize, kSize}}}, kSize, lying},
      {"lying capsule rolls", false, true, {{.shape = Capsule{kSize, kSize}}}, kSize, lying},
      {"lying cylinder rolls", false, true, {{.shape = Cylinder{kSize, kSize}}}, kSize, lying},
      {"upright cylinder", true, false, {{.shape = Cylinder{kSize, kSize}}}},
      {"cone", true, false, {{.shape = Cone{kSize, kSize}}}},
      {"box", true, false, {{.shape = Box{half}}}},
      {"hull of a box", true, false, {{.shape = collision::ConvexHull::make(box_corners(half))}}},
      {"compound of two boxes",
       true,
       false,
       {{.shape = Box{slim}, .local = {.position = Vec3(0.0, 0.5 * kSize, 0.0)}},
        {.shape = Box{slim}, .local = {.position = Vec3(0.0, -0.5 * kSize, 0.0)}}}},
  };
}

enum class Seam { One, Boxes, Kinematic, Meshes, Fields, Junction, Tiles };

std::string name_of(Seam seam) {
  switch (seam) {
    case Seam::One:
      return "one box";
    case Seam::Boxes:
      return "two boxes";
    case Seam::Kinematic:
      return "two kinematic boxes";
    case Seam::Meshes:
      return "two meshes";
    case Seam::Fields:
      return "two fields";
    case Seam::Junction:
      return "T-junction";
    case Seam::Tiles:
      return "ten boxes";
  }
  return "";
}

constexpr double kReach = 20.0;  // m
constexpr double kTile = 0.7;    // m

/// Triangles whose border at x = 0 has corners that the other side lacks.
collision::Shape junction() {
  const double r = kReach;
  const double middle = 0.1;
  const std::vector<Vec3> corners = {{-r, -r, 0.0},      {0.0, -r, 0.0},  {0.0, r, 0.0},
                                     {-r, r, 0.0},       {r, -r, 0.0},    {r, r, 0.0},
                                     {0.0, middle, 0.0}, {r, middle, 0.0}};
  const std::vector<collision::TriangleMesh::Triangle> triangles = {
      {0, 1, 2}, {0, 2, 3}, {1, 4, 7}, {1, 7, 6}, {6, 7, 5}, {6, 5, 2}};
  return collision::TriangleMesh::make(corners, triangles);
}

void add_box(AnyWorld& scene, const SolidDef& base, double low, double high) {
  SolidDef def = base;
  def.pose.position = Vec3(0.5 * (low + high), 0.0, -0.5);
  scene.add(Box{0.5 * (high - low), kReach, 0.5}, def);
}

/// The seam is at x = 0.
void add_seam(AnyWorld& scene, Seam seam, double friction) {
  SolidDef def{.type = seam == Seam::Kinematic ? BodyType::Kinematic : BodyType::Static,
               .material = {.friction = friction}};
  switch (seam) {
    case Seam::One:
      add_box(scene, def, -kReach, kReach);
      return;
    case Seam::Boxes:
    case Seam::Kinematic:
      add_box(scene, def, -kReach, 0.0);
      add_box(scene, def, 0.0, kReach);
      return;
    case Seam::Tiles:
      add_box(scene, def, -kReach, 0.0);
      for (int i = 0; i < 8; ++i) add_box(scene, def, i * kTile, (i + 1) * kTile);
      add_box(scene, def, 8 * kTile, kReach);
      return;
    case Seam::Meshes:
      scene.add(level_mesh(-kReach, 0.0, kReach, 8, 11), def);
      scene.add(level_mesh(0.0, kReach, kReach, 7, 13), def);
      return;
    case Seam::Fields: {
      const std::vector<double> heights(9 * 9, 0.0);
      const auto field = collision::HeightField::make(9, 9, kReach / 8, kReach / 4, heights);
      def.pose.position = Vec3(-kReach, -kReach, 0.0);
      scene.add(field, def);
      def.pose.position = Vec3(0.0, -kReach * 0.9, 0.0);
      scene.add(field, def);
      return;
    }
    case Seam::Junction:
      scene.add(junction(), def);
      return;
  }
}

struct Crossing {
  double speed = 0.0;  ///< m/s, minimum or maximum on the way, whichever is farther off
  double hop = 0.0;    ///< m
  double way = 0.0;    ///< m, along x
};

/// @param end  m, where the run ends, unless the body stops earlier
Crossing cross(const bench::MakeEngine& peer, const Mover& mover, Seam seam, double friction,
               double speed, double from, double end) {
  const auto world = make_world(peer);
  AnyWorld& scene = *world;
  add_seam(scene, seam, friction);
  SolidDef def{.material = {.friction = friction}};
  def.pose = {.position = Vec3(from, 0.013, mover.height), .orientation = mover.turn};
  def.twist.linear = Vec3(speed, 0.0, 0.0);
  if (mover.rolls) def.twist.angular = Vec3(0.0, speed / mover.height, 0.0);
  def.can_sleep = false;
  const BodyId body = scene.add(mover.parts, def);
  Crossing result{.speed = speed};
  const double longest = 60.0 + 3.0 * (end - from) / speed;
  for (double t = 0.0; t < longest; t += kFrame) {
    scene.step(kFrame);
    const double now = scene.twist(body).linear.x();
    const Vec3 place = scene.pose(body).position;
    if (std::abs(now - speed) > std::abs(result.speed - speed)) result.speed = now;
    result.hop = std::max(result.hop, std::abs(place.z() - mover.height));
    result.way = place.x() - from;
    if (place.x() > end || now < 1e-3 * speed) break;
  }
  return result;
}

void check_crossing(Tally& tally, Extent extent, const bench::MakeEngine& peer, const Mover& mover,
                    Seam seam) {
  const std::vector<double> speeds =
      extent == Extent::Full ? std::vector{0.1, 0.5, 2.0, 5.0, 10.0} : std::vector{2.0};
  const int phases = extent == Extent::Full ? 12 : 2;
  const double bound = mover.flat ? 0.3 : 2.0;
  for (const double speed : speeds) {
    for (int phase = 0; phase < phases; ++phase) {
      const double from =
          -(1.2 * kSize + speed * kFrame * (2.0 + phase / static_cast<double>(phases)));
      const double end = (seam == Seam::Tiles ? 8 * kTile : 0.0) + 1.5 * kSize + 0.1 * speed;
      const double friction = mover.rolls ? 0.5 : 0.0;
      const Crossing one = cross(peer, mover, seam, friction, speed, from, end);
      const std::string which = told({{"speed", speed}, {"phase", phase}});
      tally.at_most("speed", 100.0 * std::abs(one.speed / speed - 1.0), bound, "%", which);
      tally.at_most("hop", 1e3 * one.hop, 1.0, "mm", which);
    }
  }
}

/// With friction it stops at the same place as on one box.
void check_stop(Tally& tally, Extent extent, const bench::MakeEngine& peer, const Mover& mover,
                Seam seam) {
  const std::vector<double> speeds =
      extent == Extent::Full ? std::vector{1.0, 3.0, 6.0} : std::vector{3.0};
  const int phases = extent == Extent::Full ? 12 : 1;
  for (const double speed : speeds) {
    const double way = speed * speed / (2.0 * 0.5 * kGravity);
    const double plain = cross(peer, mover, Seam::One, 0.5, speed, 0.0, kReach).way;
    for (int phase = 0; phase < phases; ++phase) {
      const double from = -way * (0.2 + 0.6 * phase / std::max(1, phases - 1));
      const double off = std::abs(cross(peer, mover, seam, 0.5, speed, from, kReach).way - plain);
      tally.at_most("stopping distance", 1e3 * off, std::max(1.0, 10.0 * plain), "mm",
                    told({{"speed", speed}, {"phase", phase}}));
    }
  }
}

}  // namespace

std::vector<Group> seam_groups(const bench::MakeEngine& peer) {
  std::vector<Group> groups;
  for (const Seam seam :
       {Seam::Boxes, Seam::Kinematic, Seam::Meshes, Seam::Fields, Seam::Junction, Seam::Tiles}) {
    for (const Mover& mover : movers()) {
      groups.push_back({"E1", mover.name, name_of(seam),
                        [=](Tally& tally, Extent extent) {
                          check_crossing(tally, extent, peer, mover, seam);
                          if (mover.flat) check_stop(tally, extent, peer, mover, seam);
                        },
                        seam == Seam::Boxes || seam == Seam::Meshes});
    }
  }
  return groups;
}

}  // namespace tandem::everyday
