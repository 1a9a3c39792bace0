// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Random trees fall as MuJoCo has them fall: frames, axes, masses, and what acts along joints.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "models.h"
#include "mujoco.h"
#include "random_tree.h"
#include "support/catch.h"

namespace mjcf_test {
namespace {

using namespace tandem;

/// How far a tree is from where MuJoCo has it.
struct Off {
  double way = 0.0;     ///< m, of the tree's centre of mass in MuJoCo
  double centre = 0.0;  ///< m, of the same
  double turn = 0.0;    ///< rad, of the body for which it is largest
  double joint = 0.0;   ///< m or rad, of the slide or hinge for which it is largest
};

/// After half a second. @param rate  steps of Tandem in a second; MuJoCo takes ten times as many
Off half_a_second(const RandomTree& tree, int rate) {
  SceneFile file = parse_mjcf(tree.text);
  Mujoco reference(tree.text, 0.1 / rate);
  for (std::size_t a = 0; a < tree.controls.size(); ++a) {
    file.set_control(a, tree.controls[a]);
    reference.data().ctrl[a] = tree.controls[a];
  }
  const mjModel& m = reference.model();
  const auto centre = [&] {
    Vec3 sum = Vec3::Zero();
    for (int b = 1; b < m.nbody; ++b) sum += m.body_mass[b] * reference.centre(b);
    return Vec3(sum / m.body_subtreemass[0]);
  };
  const Vec3 from = centre();
  for (int i = 0; i < rate / 2; ++i) file.scene.step(1.0 / rate);
  reference.run(0.5);
  Off off{.way = (centre() - from).norm()};
  Vec3 sum = Vec3::Zero();
  for (int b = 1; b < m.nbody; ++b) {
    const Pose pose = file.pose(mj_id2name(&m, mjOBJ_BODY, b));
    sum += m.body_mass[b] *
           pose.to_world({m.body_ipos[3 * b], m.body_ipos[3 * b + 1], m.body_ipos[3 * b + 2]});
    off.turn = std::max(off.turn, pose.orientation.angularDistance(reference.turn(b)));
  }
  off.centre = (sum / m.body_subtreemass[0] - centre()).norm();
  for (int j = 0; j < m.njnt; ++j) {
    const char* name = mj_id2name(&m, mjOBJ_JOINT, j);
    if (name == nullptr || m.jnt_type[j] == mjJNT_BALL) continue;
    const pbd::JointId id = file.find_joint(name);
    const auto& at = file.scene.joints().at(id).position;
    const auto& def = file.scene.joints().def(id);
    // Which coordinate of the joint it is, and which way it runs, the file does not say.
    double nearest = pbd::kUnlimited;
    for (std::size_t c = 0; c < 4; ++c) {
      const pbd::JointAxis& axis = c < 3 ? def.linear[c] : def.angular[0];
      if (axis.freedom == pbd::Freedom::Locked) continue;
      if ((c == 3) != (m.jnt_type[j] == mjJNT_HINGE)) continue;
      nearest = std::min(
          {nearest, std::abs(at[c] - reference.moved(j)), std::abs(-at[c] - reference.moved(j))});
    }
    off.joint = std::max(off.joint, nearest);
  }
  return off;
}

TEST_CASE("mjcf: random trees fall as MuJoCo's do", "[mjcf]") {
  constexpr double kDegree = std::numbers::pi / 180.0;
  constexpr int kRate = 960;
  int coarse = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const RandomTree tree(seed);
    const Off off = half_a_second(tree, kRate);
    CHECK(off.way > 1e-3);
    CHECK(off.centre < std::max(2e-3, 0.01 * off.way));
    if (off.turn < kDegree && off.joint < kDegree) continue;
    // Light bodies that come to spin at 40 to 70 rad/s: it is the step that is off, for MuJoCo as
    // well, and a shorter one less so.
    ++coarse;
    const Off finer = half_a_second(tree, 4 * kRate);
    CHECK(finer.turn < 0.4 * off.turn);
    CHECK(finer.joint < 0.4 * off.joint);
  }
  CHECK(coarse <= 2);
}

TEST_CASE("mjcf: random trees with several hinges to a body fall like MuJoCo's", "[mjcf]") {
  constexpr double kDegree = std::numbers::pi / 180.0;
  int off_by_one = 0;
  int off_by_five = 0;
  int astray = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const Off off = half_a_second(RandomTree(seed, true), 960);
    CHECK(off.way > 1e-3);
    const double turn = std::max(off.turn, off.joint);
    off_by_one += turn > kDegree ? 1 : 0;
    off_by_five += turn > 5.0 * kDegree ? 1 : 0;
    astray += off.centre > std::max(2e-3, 0.01 * off.way) ? 1 : 0;
  }
  // Undamped links of 0.1 m that turn over: what stands between has 0.003 of their inertia.
  CHECK(off_by_one <= 15);
  CHECK(off_by_five <= 3);
  CHECK(astray <= 3);
}

}  // namespace
}  // namespace mjcf_test
