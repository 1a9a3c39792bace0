// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The scenes of joints are what they are said to be, and so each engine is given them.
#include "scenes/joint_scenes.h"

#include <algorithm>

#include "measure/quality.h"
#include "scenes/doll.h"
#include "support/catch.h"
#include "taking_engines.h"

namespace joint_scenes_test {

using namespace tandem::bench;

TEST_CASE("joint scenes: are as large as they are said to be, and begin closed",
          "[numerics][engines]") {
  const auto dynamic = [](const Scene& scene) {
    return std::count_if(scene.bodies.begin(), scene.bodies.end(),
                         [](const SceneBody& body) { return body.type == BodyType::Dynamic; });
  };
  for (const std::string_view name : kJointScenes) {
    INFO(name);
    REQUIRE(is_joint_scene(name));
    const Scene scene = joint_scene(name);
    for (const SceneJoint& joint : scene.joints) {
      REQUIRE(std::min(joint.a, joint.b) >= -1);
      REQUIRE(std::max(joint.a, joint.b) < static_cast<int>(scene.bodies.size()));
      CHECK(scene.bodies[static_cast<std::size_t>(joint.b)].type == BodyType::Dynamic);
      CHECK(joint.axis_w.norm() == Approx(1.0));
    }
    for_each_engine(scene, [&](const Engine& engine) {
      for (const double apart : joint_separations(scene, engine)) CHECK(apart < 2e-5);
    });
  }
  CHECK(dynamic(joint_scene("joint_grid", 100)) == 9900);
  // 19 800 in Box3D's, of which 99 hold what is fixed to what is fixed.
  CHECK(joint_scene("joint_grid", 100).joints.size() == 19701);
  CHECK(dynamic(joint_scene("rain", 20)) == 840);
  CHECK(dynamic(joint_scene("bridge")) == 200 + 5);
  CHECK(dynamic(joint_scene("doors")) == 100);
  CHECK_THROWS_AS(joint_scene("rein"), std::invalid_argument);
}

TEST_CASE("joint scenes: a doll has the mass of Box3D's, and left and right are alike",
          "[numerics][engines]") {
  const Scene scene = joint_scene("human");
  CHECK(scene.joints.size() == kDollJoints);
  double mass = 0.0;
  double left = 0.0;
  for (const SceneBody& body : scene.bodies) {
    mass += body.mass;
    left += body.mass * body.pose.position.y();
  }
  CHECK(mass == Approx(137.17).epsilon(1e-3));  // of its capsules, at 1000 kg/m^3
  CHECK(left == Approx(0.0).margin(1e-9));
}

TEST_CASE("joint scenes: dolls fall freely through their first frame", "[numerics][engines]") {
  // Not those of rain, whose arms begin within each other, as in Box3D's.
  for (const std::string_view name : {"human", "wedge"}) {
    INFO(name);
    const Scene scene = joint_scene(name);
    for_each_engine(scene, [&](Engine& engine) {
      engine.step(scene.dt);
      const double n = engine.stats().substeps;
      const Vec3 velocity = scene.dt * scene.gravity;
      const Vec3 way = 0.5 * (1.0 + 1.0 / n) * scene.dt * velocity;
      for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].type != BodyType::Dynamic) continue;
        const tandem::pbd::BodyState now = engine.state(static_cast<int>(i));
        CHECK((now.pose.position - scene.bodies[i].pose.position - way).norm() < 1e-4);
        CHECK((now.twist.linear - velocity).norm() < 2e-3);
        CHECK(now.twist.angular.norm() < 2e-2);
      }
    });
  }
}

}  // namespace joint_scenes_test
