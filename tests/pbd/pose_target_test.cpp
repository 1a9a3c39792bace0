// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/pose_target.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "support/catch.h"
#include "support/targets.h"

namespace pose_target_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const Vec3 kHalf(0.1, 0.2, 0.3);

/// One free body with one target.
struct Free {
  World world;
  FixedTargets source;
  BodyId body;

  explicit Free(double share, const Vec3& gravity = Vec3::Zero()) : world({.gravity = gravity}) {
    BodyDef def = box_def(2.0, kHalf, Vec3(1.0, 2.0, 3.0), turn(Vec3(0.2, -0.4, 1.0)));
    def.twist = {Vec3(1.0, -0.5, 0.2), Vec3::Zero()};
    body = world.add_body(def);
    PoseTarget target{.body = body, .share = share};
    target.pose = {Vec3(1.2, 2.1, 2.7), turn(Vec3(0.1, 0.5, -0.3)) * def.pose.orientation};
    target.twist = {Vec3(0.4, 0.6, -0.1), Vec3::Zero()};
    source.targets.push_back(target);
    world.set_target_source(&source);
  }
  PoseTarget& target() { return source.targets[0]; }
  const Pose& pose() const { return world.pose(body); }
  const Twist& twist() const { return world.twist(body); }
};

/// How far a body falls in n substeps of semi-implicit Euler, m.
Vec3 fall(const Vec3& gravity, double h, int n) { return gravity * h * h * (0.5 * n * (n + 1)); }

}  // namespace

TEST_CASE("pose_target: a free body ends at the weighted average of both states",
          "[pbd][consensus][analytic]") {
  for (const Vec3& gravity : {Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, -9.81)}) {
    for (const double share : {1e-9, 0.05, 0.3, 0.9, 1.0}) {
      for (const int n : {1, 4, 10, 20}) {
        Free scene(share, gravity);
        const BodyState start = scene.world.state(scene.body);
        const PoseTarget target = scene.target();
        Solver solver({.substeps = n});
        solver.step(scene.world, kFrame);
        // [friston] Eq. 1 with local weight 1 - s: both states feel gravity, so it adds to both.
        const Vec3 local = start.pose.position + kFrame * start.twist.linear;
        const Vec3 remote = target.pose.position + kFrame * target.twist.linear;
        const Vec3 x = (1.0 - share) * local + share * remote + fall(gravity, kFrame / n, n);
        const Vec3 v =
            (1.0 - share) * start.twist.linear + share * target.twist.linear + kFrame * gravity;
        INFO("share " << share << ", " << n << " substeps, gravity " << gravity.z());
        REQUIRE((scene.pose().position - x).norm() < 1e-12);
        REQUIRE((scene.twist().linear - v).norm() < 1e-12);
      }
    }
  }
}

TEST_CASE("pose_target: peers fused by hand give the weighted average over all of them",
          "[pbd][consensus][analytic]") {
  const std::vector<double> weights{0.1, 1.0, 0.03, 2.5};
  const std::vector<Vec3> positions{Vec3(1.1, 2.0, 3.0), Vec3(0.7, 2.2, 3.1), Vec3(4.0, 1.0, 3.0),
                                    Vec3(1.0, 1.9, 2.8)};
  for (std::size_t k = 1; k <= weights.size(); ++k) {
    Free scene(0.0);
    double sum = 0.0;
    Vec3 mean = Vec3::Zero();
    for (std::size_t i = 0; i < k; ++i) {
      sum += weights[i];
      mean += weights[i] * positions[i];
    }
    scene.world.set_twist(scene.body, {});
    scene.target().twist = {};
    scene.target().share = share_of(sum);
    scene.target().pose.position = mean / sum;
    const Vec3 expected = (scene.pose().position + mean) / (1.0 + sum);
    Solver solver;
    solver.step(scene.world, kFrame);
    INFO(k << " peers");
    CHECK((scene.pose().position - expected).norm() < 1e-12);
  }
}

TEST_CASE("pose_target: a rotation error e is closed by exp(s e), in one part or in twenty",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    for (const double angle : {1e-6, 0.1, 1.0, 3.0}) {
      for (const double share : {0.05, 0.5, 0.9, 1.0}) {
        Free scene(share);
        const Quat start = scene.pose().orientation;
        const Vec3 error = angle * Vec3(2.0, -1.0, 0.5).normalized();
        scene.target().pose.orientation = turn(error) * start;
        Solver solver({.substeps = substeps});
        solver.step(scene.world, kFrame);
        CHECK(angle_between(scene.pose().orientation, turn(share * error) * start) < 1e-9);
      }
    }
  }
}

TEST_CASE("pose_target: a given rotation error may lie beyond half a turn",
          "[pbd][consensus][unit]") {
  Free scene(0.5);
  const Quat start = scene.pose().orientation;
  scene.target().rotation_error = Vec3(0.0, 0.0, 4.0);  // atan2 of a fused rotation: up to 2 pi
  scene.target().use_rotation_error = true;
  scene.target().pose.orientation = start;  // not read
  Solver solver;
  solver.step(scene.world, kFrame);
  CHECK(angle_between(scene.pose().orientation, turn(Vec3(0.0, 0.0, 2.0)) * start) < 1e-9);
}

TEST_CASE("pose_target: spinning about one axis, angle and rate are averaged",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    const double share = 0.3;
    Free scene(share);
    const Vec3 axis = Vec3::UnitZ();
    scene.world.set_pose(scene.body, {Vec3::Zero(), turn(0.2 * axis)});
    scene.world.set_twist(scene.body, {Vec3::Zero(), 3.0 * axis});
    scene.target().pose = {Vec3::Zero(), turn(0.5 * axis)};
    scene.target().twist = {Vec3::Zero(), 5.0 * axis};
    Solver solver({.substeps = substeps});
    solver.step(scene.world, kFrame);
    const double angle = (1.0 - share) * (0.2 + 3.0 * kFrame) + share * (0.5 + 5.0 * kFrame);
    CHECK(angle_between(scene.pose().orientation, turn(angle * axis)) < 1e-12);
    CHECK((scene.twist().angular - (0.7 * 3.0 + 0.3 * 5.0) * axis).norm() < 1e-12);
  }
}

TEST_CASE("pose_target: share 1 makes the remote state the owner's", "[pbd][consensus][unit]") {
  for (const int substeps : {1, 4, 10}) {
    Free scene(1.0, Vec3(0.0, 0.0, -9.81));
    scene.target().motion = TargetMotion::Inertial;
    const PoseTarget target = scene.target();
    Solver solver({.substeps = substeps});
    solver.step(scene.world, kFrame);
    CHECK((scene.pose().position - target.pose.position - kFrame * target.twist.linear).norm() <
          1e-12);
    CHECK((scene.twist().linear - target.twist.linear).norm() < 1e-12);
    CHECK(angle_between(scene.pose().orientation, target.pose.orientation) < 1e-9);
  }
}

TEST_CASE("pose_target: an inertial target does not fall, and the pull against gravity is exact",
          "[pbd][consensus][analytic]") {
  const double share = 0.4;
  for (const int n : {1, 4, 10}) {
    const double h = kFrame / n;
    Free scene(share, Vec3(0.0, 0.0, -9.81));
    scene.target().motion = TargetMotion::Inertial;
    const PoseTarget target = scene.target();
    Vec3 x = scene.pose().position;
    Vec3 v = scene.twist().linear;
    const double part = 1.0 - std::pow(1.0 - share, 1.0 / n);
    for (int k = 1; k <= n; ++k) {
      v += h * Vec3(0.0, 0.0, -9.81);
      x += h * v;
      v += part * (target.twist.linear - v);
      x += part * (target.pose.position + k * h * target.twist.linear - x);
    }
    Solver solver({.substeps = n});
    solver.step(scene.world, kFrame);
    CHECK((scene.pose().position - x).norm() < 1e-12);
    CHECK((scene.twist().linear - v).norm() < 1e-12);
  }
}

TEST_CASE("pose_target: a share means the same for every length of step",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    Free whole(0.3);
    Free halves(0.3);
    const PoseTarget start = whole.target();
    Solver solver({.substeps = substeps});
    solver.step(whole.world, kFrame);
    for (int i = 0; i < 2; ++i) {
      halves.target().pose.position = start.pose.position + i * 0.5 * kFrame * start.twist.linear;
      solver.step(halves.world, 0.5 * kFrame);
    }
    CHECK((whole.pose().position - halves.pose().position).norm() < 1e-12);
    CHECK((whole.twist().linear - halves.twist().linear).norm() < 1e-12);
    CHECK(angle_between(whole.pose().orientation, halves.pose().orientation) < 1e-9);
  }
}

TEST_CASE("pose_target: the reported correction is agreement's displacement",
          "[pbd][consensus][unit]") {
  Free with(0.25, Vec3(0.0, 0.0, -9.81));
  Free without(0.0, Vec3(0.0, 0.0, -9.81));
  Solver solver;
  solver.step(with.world, kFrame);
  solver.step(without.world, kFrame);
  const Correction c = with.world.correction(with.body);
  // The position also runs on with the corrected velocity in the later substeps, so the twist's
  // part of it is not displacement: 1/60 s of at most |c.twist|.
  const Vec3 moved = with.pose().position - without.pose().position;
  CHECK((moved - c.translation).norm() <= kFrame * c.twist.linear.norm());
  CHECK(c.translation.norm() > 0.05);
  CHECK((c.twist.linear - 0.25 * (with.target().twist.linear - Vec3(1.0, -0.5, 0.2))).norm() <
        1e-12);
  CHECK(c.rotation.norm() == Approx(0.25 * Vec3(0.1, 0.5, -0.3).norm()).epsilon(1e-9));
  CHECK(without.world.correction(without.body).translation.norm() == 0.0);
  with.source.targets.clear();
  solver.step(with.world, kFrame);
  CHECK(with.world.correction(with.body).translation.norm() == 0.0);
}

TEST_CASE("pose_target: targets that are no numbers, or for no body, are ignored",
          "[pbd][consensus][fault]") {
  const std::vector<std::function<void(PoseTarget&)>> spoils{
      [](PoseTarget& t) { t.pose.position.x() = kNan; },
      [](PoseTarget& t) { t.pose.position.y() = -kInf; },
      [](PoseTarget& t) { t.pose.orientation = Quat(kNan, 0.0, 0.0, 0.0); },
      [](PoseTarget& t) { t.pose.orientation = Quat(0.0, 0.0, 0.0, 0.0); },
      [](PoseTarget& t) { t.pose.orientation = Quat(1.0, 1.0, 1.0, 1.0); },
      [](PoseTarget& t) { t.twist.linear.z() = kNan; },
      [](PoseTarget& t) { t.twist.angular.x() = kInf; },
      [](PoseTarget& t) { t.rotation_error.x() = kNan; },
      [](PoseTarget& t) { t.share = kNan; },
      [](PoseTarget& t) { t.share = kInf; },
      [](PoseTarget& t) { t.share = 0.0; },
      [](PoseTarget& t) { t.share = -0.5; },
      [](PoseTarget& t) { t.body = {}; },
      [](PoseTarget& t) { t.body.generation = 9; },
      [](PoseTarget& t) { t.body.index = 1000; },
  };
  Free plain(0.0);
  plain.world.set_target_source(nullptr);
  Solver solver;
  solver.step(plain.world, kFrame);
  for (std::size_t i = 0; i < spoils.size(); ++i) {
    Free scene(0.5);
    spoils[i](scene.target());
    const StepReport& report = solver.step(scene.world, kFrame);
    INFO("case " << i);
    CHECK(scene.source.collected == 1);
    CHECK(report.status == StepStatus::Ok);
    CHECK(report.targets == 0);
    CHECK(scene.world.hash() == plain.world.hash());
  }
}

TEST_CASE("pose_target: a share above 1 is an owner's", "[pbd][consensus][fault]") {
  Free one(1.0);
  Free more(7.0);
  Solver solver;
  solver.step(one.world, kFrame);
  solver.step(more.world, kFrame);
  CHECK(one.world.hash() == more.world.hash());
}

TEST_CASE("pose_target: bodies that do not move freely take no target", "[pbd][consensus][unit]") {
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
    World world;
    FixedTargets source;
    const BodyId body = world.add_body({.type = type});
    source.targets.push_back(
        {.body = body, .pose = {Vec3(1.0, 0.0, 0.0), Quat::Identity()}, .share = 1.0});
    world.set_target_source(&source);
    Solver solver;
    CHECK(solver.step(world, kFrame).targets == 0);
    CHECK(world.pose(body).position.norm() == 0.0);
  }
}

}  // namespace pose_target_test
