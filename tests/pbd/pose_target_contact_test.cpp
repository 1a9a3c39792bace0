// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/pose_target.h"

namespace pose_target_contact_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.5, 0.5, 0.5);

/// A floor at z = 0, tilted about y, with a column of cubes.
struct Scene {
  World world;
  ToyContacts contacts;
  FixedTargets source;
  std::vector<BodyId> boxes;

  Scene(int count, double tilt, double friction, const Vec3& gravity = Vec3(0.0, 0.0, -9.81))
      : world({.gravity = gravity}) {
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    const Vec3 normal(std::sin(tilt), 0.0, std::cos(tilt));
    for (int i = 0; i < count; ++i) {
      boxes.push_back(
          world.add_body(box_def(1.0, kHalf, (0.5 + i) * normal, turn(Vec3(0.0, tilt, 0.0)))));
      if (i == 0) {
        contacts.box_on_plane(ground, normal, 0.0, boxes[0], kHalf, {.friction = friction});
      } else {
        contacts.box_on_box(boxes[static_cast<std::size_t>(i - 1)], kHalf, boxes.back(), kHalf,
                            {.friction = friction});
      }
    }
  }
  const Vec3& position(int i = 0) const {
    return world.pose(boxes[static_cast<std::size_t>(i)]).position;
  }
};

/// A weightless cube that touches the wall x = 0 from the right, in a world of its own.
struct Wall {
  World world{weightless()};
  ToyContacts contacts;
  FixedTargets source;
  BodyId box;

  explicit Wall(double share) {
    world.set_contact_source(&contacts);
    const BodyId wall = add_ground(world);
    box = world.add_body(box_def(1.0, kHalf, Vec3(0.5, 0.0, 0.0)));
    contacts.box_on_plane(wall, Vec3::UnitX(), 0.0, box, kHalf, {});
    source.targets.push_back(
        {.body = box, .pose = {Vec3(0.49, 0.0, 0.0), Quat::Identity()}, .share = share});
    world.set_target_source(&source);
  }
  double depth() const { return 0.5 - world.pose(box).position.x(); }
};

/// Steps `with` beside `without`; each target follows the body of `without`, `offset` away from it.
double run_beside(Scene& with, Scene& without, double share, const Vec3& offset, double seconds) {
  with.world.set_target_source(&with.source);
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  double largest = 0.0;
  const int steps = static_cast<int>(std::lround(seconds / kFrame));
  for (int k = 0; k < steps; ++k) {
    with.source.targets.clear();
    for (const BodyId id : with.boxes) {
      const BodyState& twin = without.world.state(id);
      with.source.targets.push_back({.body = id,
                                     .pose = {twin.pose.position + offset, twin.pose.orientation},
                                     .twist = twin.twist,
                                     .share = share});
    }
    solver.step(with.world, kFrame);
    solver.step(without.world, kFrame);
    for (const BodyId id : with.boxes) {
      largest = std::max(largest,
                         (with.world.pose(id).position - without.world.pose(id).position).norm());
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("pose_target contact: a target 10 mm inside a wall leaves the body at rest outside it",
          "[pbd][consensus][regression]") {
  for (const int substeps : {1, 4, 10}) {
    for (const double share : {0.05, 0.5, 0.9, 1.0}) {
      Wall scene(share);
      Solver solver({.substeps = substeps});
      double deepest = 0.0;
      double fastest = 0.0;
      run(scene.world, solver, 2.0, [&] {
        deepest = std::max(deepest, scene.depth());
        fastest = std::max(fastest, scene.world.twist(scene.box).linear.norm());
      });
      INFO("share " << share << ": depth " << deepest << " m, speed " << fastest << " m/s");
      CHECK(deepest < 1e-4);
      CHECK(fastest < 1e-6);
      CHECK(scene.depth() > -1e-3);  // and it did not leave the wall either
    }
  }
}

TEST_CASE("pose_target contact: when the targets stop, nothing remembers them",
          "[pbd][consensus][regression]") {
  for (const int substeps : {1, 4, 10}) {
    // An owner presses a body into a wall and lets go.
    Scene scene(1, 0.0, 0.5);
    scene.source.targets.push_back(
        {.body = scene.boxes[0], .pose = {Vec3(0.0, 0.0, 0.45), Quat::Identity()}, .share = 1.0});
    scene.world.set_target_source(&scene.source);
    Solver solver({.substeps = substeps});
    run(scene.world, solver, 0.5);
    scene.source.targets.clear();
    double fastest = 0.0;
    run(scene.world, solver, 2.0,
        [&] { fastest = std::max(fastest, scene.world.twist(scene.boxes[0]).linear.norm()); });
    INFO("depth " << 0.5 - scene.position().z() << " m, fastest " << fastest << " m/s");
    CHECK(std::abs(0.5 - scene.position().z()) < 1e-3);
    CHECK(fastest < 0.1);
    CHECK(scene.world.twist(scene.boxes[0]).linear.norm() < 1e-4);
    CHECK(scene.world.in_contact(scene.boxes[0]));
  }
}

TEST_CASE("pose_target contact: a share of 1e-6 leaves a sliding box where none would have it",
          "[pbd][consensus][regression]") {
  const double tilt = 20.0 * kPi / 180.0;
  for (const Vec3& offset : {Vec3(0.005, 0.0, 0.0), Vec3(0.0, 0.0, 0.005), Vec3(0.0, 0.0, -0.005),
                             Vec3(0.0, 0.005, 0.0)}) {
    for (const double friction : {0.2, 0.38}) {
      Scene with(1, tilt, friction);
      Scene without(1, tilt, friction);
      const double apart = run_beside(with, without, 1e-6, offset, 1.0);
      INFO("offset " << offset.transpose() << " mu " << friction << ": " << apart << " m");
      CHECK(apart < 1e-6);
      CHECK(apart > 0.0);  // the target is there
    }
  }
}

TEST_CASE("pose_target contact: a share of 1e-6 leaves a stack where none would have it",
          "[pbd][consensus][regression]") {
  for (const Vec3& offset :
       {Vec3(0.005, 0.0, 0.0), Vec3(0.0, 0.0, 0.005), Vec3(0.0, 0.0, -0.005)}) {
    Scene with(5, 0.0, 0.5);
    Scene without(5, 0.0, 0.5);
    const double apart = run_beside(with, without, 1e-6, offset, 1.0);
    INFO("offset " << offset.transpose() << ": " << apart << " m");
    CHECK(apart < 1e-6);
    CHECK(apart > 0.0);
  }
}

TEST_CASE("pose_target contact: a target where the body is leaves friction alone",
          "[pbd][consensus][regression]") {
  // With any share: what agreement asks for is nothing, so nothing may change.
  const double tilt = 20.0 * kPi / 180.0;
  Scene with(1, tilt, 0.2);
  with.world.set_target_source(&with.source);
  Solver solver;
  run(with.world, solver, 1.0, [&] {
    const BodyState& own = with.world.state(with.boxes[0]);
    with.source.targets.assign(
        1, {.body = with.boxes[0], .pose = own.pose, .twist = own.twist, .share = 0.5});
  });
  const double acceleration = kGravity * (std::sin(tilt) - 0.2 * std::cos(tilt));
  CHECK((with.position() - 0.5 * Vec3(std::sin(tilt), 0.0, std::cos(tilt))).norm() ==
        Approx(0.5 * acceleration).epsilon(0.03));
}

TEST_CASE("pose_target contact: a stack that remote peers see 2 mm aside follows and stands",
          "[pbd][consensus][regression]") {
  for (const int substeps : {1, 4, 10}) {
    Scene scene(5, 0.0, 0.5);
    scene.world.set_target_source(&scene.source);
    for (int i = 0; i < 5; ++i) {
      scene.source.targets.push_back({.body = scene.boxes[static_cast<std::size_t>(i)],
                                      .pose = {Vec3(0.002, -0.001, 0.5 + i), Quat::Identity()},
                                      .share = 0.1});
    }
    Solver solver({.substeps = substeps});
    run(scene.world, solver, 5.0);
    double fastest = 0.0;
    run(scene.world, solver, 1.0, [&] {
      for (const BodyId id : scene.boxes) {
        fastest = std::max(fastest, scene.world.twist(id).linear.norm());
      }
    });
    for (int i = 0; i < 5; ++i) {
      INFO("box " << i << " at " << scene.position(i).transpose());
      CHECK((scene.position(i) - Vec3(0.002, -0.001, 0.5 + i)).norm() < 2e-4);
    }
    INFO("fastest " << fastest << " m/s");
    CHECK(fastest < 1e-3);
  }
}

TEST_CASE("pose_target contact: bodies of other islands keep their very bits",
          "[pbd][consensus][golden]") {
  // Two columns on the same floor; only the first has a target. A static floor joins no islands.
  const auto build = [](bool target, FixedTargets& source, ToyContacts& contacts, World& world,
                        std::vector<BodyId>& second) {
    world.set_contact_source(&contacts);
    auto& joints = world.add_block<JointBlock>();
    const BodyId ground = add_ground(world);
    for (int column = 0; column < 2; ++column) {
      BodyId below;
      for (int i = 0; i < 3; ++i) {
        BodyDef def = box_def(1.0, kHalf, Vec3(5.0 * column + 0.02 * i, 0.0, 0.5 + 1.01 * i));
        if (i == 0) def.twist.linear.x() = 0.4;
        const BodyId box = world.add_body(def);
        if (i == 0) {
          contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
        } else {
          contacts.box_on_box(below, kHalf, box, kHalf, {});
        }
        below = box;
        if (column == 1) second.push_back(box);
        if (column == 0 && i == 1) {
          source.targets.push_back({.body = box,
                                    .pose = {Vec3(0.1, 0.2, 1.5), turn(Vec3(0.0, 0.0, 0.2))},
                                    .share = 0.3});
        }
      }
      const BodyId pendulum = world.add_body(box_def(1.0, kHalf, Vec3(5.0 * column, 9.0, 0.0)));
      joints.add(world, ball_joint_at(world, ground, pendulum, Vec3(5.0 * column, 8.5, 0.5)));
      if (column == 1) second.push_back(pendulum);
    }
    if (target) world.set_target_source(&source);
  };
  World shared;
  World alone;
  FixedTargets source_a, source_b;
  ToyContacts contacts_a, contacts_b;
  std::vector<BodyId> second, unused;
  build(true, source_a, contacts_a, shared, second);
  build(false, source_b, contacts_b, alone, unused);
  // Enough for both columns: rows that are solved once more have one budget.
  Solver solver({.velocity_tolerance = 0.0, .contact = {.extra_rows = 1000000}});
  for (int k = 0; k < 90; ++k) {
    solver.step(shared, kFrame);
    solver.step(alone, kFrame);
  }
  for (const BodyId id : second) {
    const BodyState& a = shared.state(id);
    const BodyState& b = alone.state(id);
    CHECK(a.pose.position == b.pose.position);
    CHECK(a.pose.orientation.coeffs() == b.pose.orientation.coeffs());
    CHECK(a.twist.linear == b.twist.linear);
    CHECK(a.twist.angular == b.twist.angular);
  }
  CHECK(shared.hash() != alone.hash());  // the first column did feel its target
}

}  // namespace pose_target_contact_test
