// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Joints that mimic another one.
#include <algorithm>
#include <cmath>
#include <string>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/urdf.h"

namespace urdf_mimic_test {
namespace {

using namespace tandem;

std::string link(const std::string& name) {
  return "<link name='" + name +
         "'><inertial><origin xyz='.1 0 0'/><mass value='.2'/><inertia ixx='1e-4' iyy='8e-4' "
         "izz='8e-4' ixy='0' ixz='0' iyz='0'/></inertial></link>";
}
std::string joint(const std::string& name, const std::string& type, const std::string& from,
                  const std::string& to, const std::string& inside) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + from +
         "'/><child link='" + to + "'/><axis xyz='0 1 0'/>" + inside + "</joint>";
}
/// A gripper that a third finger and a slide go with.
std::string gripper() {
  std::string out = "<robot name='r'><link name='palm'/>";
  for (const char* name : {"a", "b", "tip", "s"}) out += link(name);
  out += joint("left", "continuous", "palm", "a", "");
  out += joint("right", "continuous", "palm", "b",
               "<origin xyz='0 0 .1'/><mimic joint='left' multiplier='-1' offset='.2'/>");
  out += joint("knuckle", "continuous", "a", "tip",
               "<origin xyz='.2 0 0'/><mimic joint='left' multiplier='.5'/>");
  out += joint("slide", "prismatic", "palm", "s",
               "<limit lower='-1' upper='1' effort='1' velocity='1'/>"
               "<mimic joint='left' multiplier='.1'/>");
  return out + "</robot>";
}

TEST_CASE("urdf: joints that mimic another one keep their ratio to it", "[urdf][coupling]") {
  SceneFile file = parse_urdf(gripper());
  CHECK(file.warnings.empty());
  const auto at = [&](const char* name, std::size_t coordinate) {
    return file.scene.joints().at(file.find_joint(name)).position[coordinate];
  };
  double farthest = 0.0;
  for (int i = 0; i < 180; ++i) {
    file.scene.step(1.0 / 60.0);
    if (i < 30) continue;  // the offset closes
    const double left = at("left", 3);
    farthest = std::max(farthest, std::abs(left));
    CHECK(std::abs(at("right", 3) + left - 0.2) < 1e-4);
    CHECK(std::abs(at("knuckle", 3) - 0.5 * left) < 1e-4);
    CHECK(std::abs(at("slide", 0) - 0.1 * left) < 1e-4);
  }
  CHECK(farthest > 0.1);
}

TEST_CASE("urdf: joints that are not to mimic another one are told", "[urdf][coupling]") {
  const SceneFile file = parse_urdf(gripper(), {.mimic = false});
  REQUIRE(file.warnings.size() == 1);
  CHECK(file.warnings[0].find(": mimic is not kept: it moves freely") != std::string::npos);
}

}  // namespace
}  // namespace urdf_mimic_test
