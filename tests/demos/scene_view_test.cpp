// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "scene_view/extent.h"
#include "scene_view/file_world.h"
#include "scene_view/load_file.h"
#include "scenes/random.h"
#include "support/catch.h"
#include "support/folder.h"
#include "tandem/collision/convex_hull.h"

namespace tandem::demos::scene_view_test {
namespace {

using collision::Aabb;
using pbd::Vec3;

constexpr double kFrame = 1.0 / 60.0;  // s
constexpr view::PageId kPage = 7;

/// A table that stands, a ball above it, a joint's bare body, and a sensor.
constexpr std::string_view kTable = R"({"bodies": [
  {"name": "table", "type": "static", "shape": {"type": "box", "halfExtents": [1, 1, 0.5]},
   "position": [0, 0, 0.25]},
  {"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "mass": 2, "position": [0, 0, 0.85]},
  {"name": "zone", "type": "static", "shape": {"type": "sphere", "radius": 9}, "sensor": true}
]})";

pbd::Pose random_pose(Random& random) {
  pbd::Pose pose;
  for (double& value : pose.position) value = random.uniform(-3.0, 3.0);
  Eigen::Vector4d q;
  for (double& value : q) value = random.uniform(-1.0, 1.0);
  pose.orientation.coeffs() = q.normalized();
  return pose;
}

/// Points that span the shape: its hull's corners, or many around its rims.
std::vector<Vec3> points_of(const collision::Shape& shape) {
  std::vector<Vec3> points;
  const auto rim = [&points](double radius, double z) {
    for (int i = 0; i < 3600; ++i) {
      const double angle = i * std::numbers::pi / 1800.0;
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  };
  if (const auto* cylinder = std::get_if<collision::Cylinder>(&shape)) {
    for (const double side : {-1.0, 1.0}) rim(cylinder->radius, side * cylinder->half_height);
  } else if (const auto* cone = std::get_if<collision::Cone>(&shape)) {
    rim(cone->radius, -cone->half_height);
    points.emplace_back(0.0, 0.0, cone->half_height);
  } else if (const auto* box = std::get_if<collision::Box>(&shape)) {
    for (int i = 0; i < 8; ++i) {
      points.push_back(box->half_extents.cwiseProduct(
          Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)));
    }
  }
  return points;
}

TEST_CASE("extent: a box that touches the shape on all sides", "[demos][view][unit]") {
  Random random(3);
  const std::vector<collision::Shape> shapes = {
      collision::Cylinder{0.3, 0.8}, collision::Cone{0.6, 0.4}, collision::Box(0.2, 0.5, 0.9)};
  for (int i = 0; i < 30; ++i) {
    const pbd::Pose pose = random_pose(random);
    for (const collision::Shape& shape : shapes) {
      Aabb around = empty_box();
      for (const Vec3& point : points_of(shape)) {
        const Vec3 at = pose.to_world(point);
        around = around.merged({at, at});
      }
      const Aabb box = extent(shape, pose);
      // Between two of 3600 points a rim bulges by r (1 - cos(pi / 3600)).
      CHECK((box.min - around.min).cwiseAbs().maxCoeff() < 1e-6);
      CHECK((box.max - around.max).cwiseAbs().maxCoeff() < 1e-6);
    }
    // A capsule is two balls and what lies between them.
    const collision::Capsule capsule{0.2, 0.7};
    Aabb balls = empty_box();
    for (const double side : {-0.7, 0.7}) {
      balls = balls.merged(extent(collision::Sphere{0.2}, {pose.to_world(Vec3(0, 0, side)), {}}));
    }
    const Aabb box = extent(capsule, pose);
    CHECK((box.min - balls.min).norm() + (box.max - balls.max).norm() < 1e-12);
  }
  CHECK(is_empty(extent(collision::HalfSpace{}, {})));
}

TEST_CASE("file world: what moves is a body, what stands is fixed, sensors are not shown",
          "[demos][view][unit]") {
  const FileWorld world(parse_scene(kTable));
  const Scene& shown = world.description();
  REQUIRE(shown.bodies.size() == 1);
  CHECK(shown.bodies[0].name == "ball");
  CHECK(shown.bodies[0].half_extents.isApproxToConstant(0.1));
  REQUIRE(shown.fixed.size() == 1);
  CHECK(std::holds_alternative<collision::Box>(shown.fixed[0].shape));
  CHECK(shown.fixed[0].pose.position.z() == 0.25);
  CHECK(world.reach() == Approx(0.95));
}

TEST_CASE("file world: a ground lies under the lowest shape, unless the file has one",
          "[demos][view][unit]") {
  const FileWorld world(parse_scene(kTable), true);
  REQUIRE(world.description().fixed.size() == 2);
  const FixedPart& ground = world.description().fixed[1];
  REQUIRE(std::holds_alternative<collision::HalfSpace>(ground.shape));
  CHECK(ground.pose.position.z() == Approx(-0.25));
  const FileWorld own(parse_scene(R"({"bodies": [
    {"type": "static", "shape": {"type": "halfSpace"}, "position": [0, 0, -4]},
    {"shape": {"type": "sphere", "radius": 1}}]})"),
                      true);
  REQUIRE(own.description().fixed.size() == 1);
  CHECK(own.description().fixed[0].pose.position.z() == -4.0);
}

TEST_CASE("file world: a restart is the start, and no hand holds on", "[demos][view][unit]") {
  FileWorld world(parse_scene(kTable));
  view::PaneFrame first, second, again;
  const auto run = [&world](int steps) {
    for (int i = 0; i < steps; ++i) world.step(kFrame);
  };
  run(20);
  world.show(first, false);
  world.restart();
  CHECK(world.time() == 0.0);
  world.grab(kPage, {1, 0, 0, Vec3(0.0, 0.0, 0.85)});
  world.move(kPage, {1, Vec3(0.0, 0.5, 1.5)});
  run(20);
  world.show(second, false);
  CHECK(second.springs.size() == 1);
  CHECK((second.poses[0].position - first.poses[0].position).norm() > 0.05);
  world.restart();
  run(20);
  world.show(again, false);
  CHECK(again.springs.empty());
  CHECK(again.poses[0].position == first.poses[0].position);
  CHECK(world.time() == Approx(20 * kFrame));
}

TEST_CASE("file world: a hand lifts a resting body, and lets go when its page is gone",
          "[demos][view][unit]") {
  FileWorld world(parse_scene(kTable));
  view::PaneFrame frame;
  const auto height_after = [&](int steps) {
    for (int i = 0; i < steps; ++i) world.step(kFrame);
    world.show(frame, true);
    return frame.poses[0].position.z();
  };
  REQUIRE(height_after(120) == Approx(0.85).margin(2e-3));
  CHECK(frame.contacts.size() == 1);
  world.grab(kPage, {1, 0, 0, Vec3(0.0, 0.0, 0.85)});
  world.move(kPage, {1, Vec3(0.0, 0.0, 1.85)});
  // A soft spring sags by a centimetre.
  CHECK(height_after(120) == Approx(1.84).margin(0.02));
  CHECK(frame.contacts.empty());
  world.leave(kPage + 1);
  CHECK(height_after(60) == Approx(1.84).margin(0.02));
  world.leave(kPage);
  CHECK(height_after(120) == Approx(0.85).margin(2e-3));
  CHECK(frame.springs.empty());
}

std::string why(const FileOptions& options) {
  try {
    load_file(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

FileOptions file(const std::string& path) {
  FileOptions options;
  options.path = path;
  return options;
}

TEST_CASE("scene files of the view: the ending decides, and errors name the file",
          "[demos][view][unit]") {
  const testing::Folder folder;
  CHECK(load_file(file(folder.write("table.JSON", std::string(kTable)))).bodies.size() == 3);
  for (const char* ending : {".json", ".gltf", ".glb", ".urdf", ".xml", ".mjcf"}) {
    const std::string name = folder.file("none") + ending;
    CHECK(why(file(name)).starts_with(name + ": "));
  }
  CHECK(why(file("robot.step")) ==
        "--scene must be a file that ends in .json, .gltf, .glb, .urdf, .xml or .mjcf, is "
        "'robot.step'");
  FileOptions wrong = file("robot.json");
  wrong.package_root = ".";
  CHECK(why(wrong) == "--package-root must be left out unless the file is URDF, is 'robot.json'");
  wrong = file("robot.urdf");
  wrong.keyframe = "home";
  CHECK(why(wrong) == "--keyframe must be left out unless the file is MJCF, is 'robot.urdf'");

  // A mesh of a package below the root, and a base that moves.
  const std::string urdf = folder.write("block.urdf", R"(<robot name="r"><link name="block">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><mesh filename="package://shapes/corner.obj"/></geometry></collision>
    </link></robot>)");
  std::filesystem::create_directory(folder.file("shapes"));
  folder.write("shapes/corner.obj",
               "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string mjcf =
      folder.write("ball.xml", R"(<mujoco><worldbody><body name="ball"><freejoint/>
    <geom size="0.1"/></body></worldbody>
    <keyframe><key name="up" qpos="0 0 3 1 0 0 0"/></keyframe></mujoco>)");
  if (!HAS_READERS) {
    const bool refused = why(file(urdf)).find("no reader of URDF") != std::string::npos ||
                         why(file(mjcf)).find("no reader of MJCF") != std::string::npos;
    CHECK(refused);
    return;
  }
  FileOptions options = file(urdf);
  options.fixed_base = false;
  CHECK(FileWorld(load_file(options)).description().bodies.empty());  // its mesh is not found
  options.package_root = std::filesystem::path(urdf).parent_path();
  const FileWorld block(load_file(options));
  REQUIRE(block.description().bodies.size() == 1);
  CHECK(block.description().bodies[0].name == "block");
  CHECK(block.reach() == Approx(1.0));
  options.package_root = folder.file("none");
  CHECK(why(options).starts_with("--package-root must be a folder"));
  options = file(mjcf);
  options.keyframe = "up";
  CHECK(load_file(options).pose("ball").position.z() == Approx(3.0));
}

}  // namespace
}  // namespace tandem::demos::scene_view_test
