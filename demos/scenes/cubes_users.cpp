// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/cubes_users.h"

#include <cmath>
#include <string>

#include "scenes/random.h"

namespace tandem::demos {

namespace {

/// Both users' knowledge: the scene's dimensions, and what they see.
struct View {
  CubesOptions cubes;
  const Scene& scene;

  pbd::Vec3 position(std::size_t body) const { return scene.pose(body).position; }
  double mass(std::size_t body) const { return scene.mass(body); }
  bool is_cube(std::size_t body) const { return scene.bodies[body].name.starts_with("cube/"); }

  /// Cubes still standing at the place of stack number `stack`, bottom to top.
  std::vector<std::size_t> standing(int stack) const {
    const pbd::Vec3 axis = scene.body("cube/" + std::to_string(stack) + "/0").start;
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (!is_cube(i)) continue;
      const pbd::Vec3 offset = position(i) - axis;
      if (offset.head<2>().norm() > 0.5 * cubes.edge) continue;
      auto at = found.begin();
      while (at != found.end() && position(*at).z() < position(i).z()) ++at;
      found.insert(at, i);
    }
    return found;
  }

  /// kg, the plate with the cubes seen on it.
  double plate_load() const {
    const std::size_t plate = scene.index_of("plate");
    const pbd::Pose& pose = scene.pose(scene.bodies[plate]);
    double load = mass(plate);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (!is_cube(i)) continue;
      const pbd::Vec3 local = pose.to_local(position(i));
      const bool above = local.z() > 0.0 && std::abs(local.x()) < 0.5 * cubes.plate.x() &&
                         std::abs(local.y()) < 0.5 * cubes.plate.y();
      if (above) load += mass(i);
    }
    return load;
  }
};

pbd::Vec3 cube_spread(const CubesOptions& cubes) {
  return pbd::Vec3(0.4 * cubes.edge, 0.4 * cubes.edge, 0.0);
}

/// Pulls the second cube from below off the plate, so that its stack topples.
HandTask throw_over(const View& view, Random& random) {
  HandTask task;
  task.start = 1.5 + random.uniform(-0.1, 0.1);
  const double away = 0.5 * view.cubes.plate.y() + 2.5 * view.cubes.edge;
  const double askew = random.uniform(-0.03, 0.03);
  task.plan = [view, away, askew]() -> std::optional<HandPlan> {
    const std::vector<std::size_t> stack = view.standing(0);
    if (stack.size() < 2) return std::nullopt;
    const std::size_t grabbed = stack[1];
    double load = 0.0;
    for (std::size_t i = 1; i < stack.size(); ++i) load += view.mass(stack[i]);
    HandPath path(0.0, view.position(grabbed));
    path.wait(0.3).move_by(pbd::Vec3(askew, -away, 0.0), 0.6).wait(0.2);
    return HandPlan{grabbed, GripSpec::for_load(load, cube_spread(view.cubes)), path};
  };
  return task;
}

/// Lifts the top cube off the last stack and puts it on the ground beside the plate.
HandTask fetch(const View& view, Random& random) {
  HandTask task;
  task.start = 2.5 + random.uniform(-0.1, 0.1);
  const pbd::Vec3 askew(random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), 0.0);
  task.plan = [view, askew]() -> std::optional<HandPlan> {
    const std::vector<std::size_t> stack = view.standing(view.cubes.stacks - 1);
    if (stack.empty()) return std::nullopt;
    const std::size_t grabbed = stack.back();
    const pbd::Vec3 from = view.position(grabbed);
    const double edge = view.cubes.edge;
    const pbd::Vec3 over(from.x() + askew.x(),
                         -(0.5 * view.cubes.plate.y() + 2.5 * edge) + askew.y(),
                         from.z() + 1.5 * edge);
    HandPath path(0.0, from);
    path.wait(0.3)
        .move_by(pbd::Vec3(0.0, 0.0, 1.5 * edge), 0.9)
        .move_to(over, 1.4)
        .move_to(pbd::Vec3(over.x(), over.y(), 0.5 * edge), 1.3)
        .wait(0.4);
    return HandPlan{grabbed, GripSpec::for_load(view.mass(grabbed), cube_spread(view.cubes)), path};
  };
  return task;
}

/// Holds the plate at one end (side -1 or +1), lifts it, carries it sideways and sets it down.
HandTask carry_plate(const View& view, double side, double start, double sideways) {
  HandTask task;
  task.start = start;
  task.plan = [view, side, sideways]() -> std::optional<HandPlan> {
    const std::size_t plate = view.scene.index_of("plate");
    const pbd::Pose& pose = view.scene.pose(view.scene.bodies[plate]);
    const double reach = 0.5 * view.cubes.plate.x() - 0.1;
    HandPath path(0.0, pose.to_world(pbd::Vec3(side * reach, 0.0, 0.0)));
    constexpr double kHeight = 0.25;
    constexpr double kPress = 0.01;  // slackens the springs once the plate is down
    path.wait(0.5)
        .move_by(pbd::Vec3(0.0, 0.0, kHeight), 2.0)
        .wait(0.2)
        .move_by(pbd::Vec3(0.0, sideways, 0.0), 2.0)
        .wait(0.2)
        .move_by(pbd::Vec3(0.0, 0.0, -kHeight - kPress), 2.0)
        .wait(0.3);
    const pbd::Vec3 spread(side * 0.08, 0.35 * view.cubes.plate.y(), 0.0);
    return HandPlan{plate, GripSpec::for_load(0.5 * view.plate_load(), spread), path};
  };
  return task;
}

}  // namespace

std::vector<HandTask> cubes_tasks(std::size_t user, const CubesOptions& cubes, const Scene& scene,
                                  const UserOptions& options) {
  const View view{cubes, scene};
  Random random(derived_seed(options.seed, 17));
  std::vector<HandTask> tasks;
  tasks.push_back(user == 0 ? throw_over(view, random) : fetch(view, random));
  const double side = user == 0 ? -1.0 : 1.0;
  double sideways = 0.3;
  for (int lift = 0;; ++lift, sideways = -sideways) {
    const double start = CubesScenario::kLiftStart + CubesScenario::kLiftPeriod * lift;
    // A session too short for a whole lift ends within the first one.
    if (lift > 0 && start + CubesScenario::kLiftPeriod > options.seconds) break;
    tasks.push_back(carry_plate(view, side, start + random.uniform(-0.1, 0.1), sideways));
  }
  return tasks;
}

}  // namespace tandem::demos
