// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/pile.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "scenes/random.h"
#include "scenes/words.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

using pbd::Vec3;

/// Distance rolled by the big cube, and small cubes that it took along or threw up.
class PileReferee final : public Referee {
 public:
  PileReferee(const PileOptions& pile, const Scene& scene)
      : pile_(pile), big_(scene.index_of("big")) {}
  void watch(const Scene& scene, double /*time*/) override {
    const Vec3 moved = scene.pose(big_).position - scene.bodies[big_].start;
    farthest_ = std::max(farthest_, moved.x());
    highest_ = std::max(highest_, moved.z());
  }
  Outcome outcome(const Scene& scene) const override {
    double displaced = 0.0, raised = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (i == big_) continue;
      const Vec3 moved = scene.pose(i).position - scene.bodies[i].start;
      if (moved.norm() > pile_.edge) displaced += 1.0;
      if (moved.z() > 0.5 * pile_.edge) raised += 1.0;
    }
    return {{"rolled_m", farthest_},
            {"raised_m", highest_},
            {"displaced", displaced},
            {"on_others", raised}};
  }

 private:
  PileOptions pile_;
  std::size_t big_;
  double farthest_ = 0.0;  ///< m
  double highest_ = 0.0;   ///< m
};

/// Holds the big cube at one end of its axis (side -1 or +1) and carries that end along x.
HandTask roll(const PileOptions& pile, const Scene& scene, double side, double start, double way) {
  HandTask task;
  task.start = start;
  task.plan = [&scene, pile, side, way]() -> std::optional<HandPlan> {
    const std::size_t big = scene.index_of("big");
    const Vec3 end = scene.pose(big).to_world(Vec3(0.0, 0.5 * side * pile.big_edge, 0.0));
    // Mean rise of a cube that rolls from face to edge.
    const double lift = 0.1 * pile.big_edge;
    HandPath path(0.0, end);
    path.wait(0.3)
        .move_by(Vec3(0.0, 0.0, lift), 0.5)
        .move_by(Vec3(way, 0.0, 0.0), PileScenario::kRoll)
        .move_by(Vec3(0.0, 0.0, -lift), 0.5)
        .wait(0.2);
    // A narrow grip, so that the cube can turn in it.
    const Vec3 spread(0.02 * pile.big_edge, 0.0, 0.02 * pile.big_edge);
    return HandPlan{big, GripSpec::for_load(scene.mass(big), spread), path};
  };
  return task;
}

}  // namespace

void PileOptions::validate() const {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  pbd::detail::require(rows >= 1 && rows <= 100, "PileOptions", "rows", rows, "from 1 to 100");
  pbd::detail::require(positive(edge), "PileOptions", "edge", edge, "finite and > 0 m");
  pbd::detail::require(std::isfinite(pitch) && pitch >= edge, "PileOptions", "pitch", pitch,
                       "finite and at least an edge");
  pbd::detail::require(positive(big_edge), "PileOptions", "big_edge", big_edge, "finite and > 0 m");
  pbd::detail::require(positive(density), "PileOptions", "density", density,
                       "finite and > 0 kg/m^3");
  pbd::detail::require(std::isfinite(friction) && friction >= 0.0, "PileOptions", "friction",
                       friction, "finite and >= 0");
}

PileScenario::PileScenario(const PileOptions& options) : Scenario("pile", 2), options_(options) {
  options_.validate();
}

Scene PileScenario::build(const SceneOptions& options) const {
  const PileOptions& o = options_;
  const auto cube = [&](double edge) { return o.density * edge * edge * edge; };
  SceneBuilder builder;
  const double half = 0.5 * o.pitch * (o.rows - 1);
  builder.box("big", Vec3::Constant(o.big_edge), cube(o.big_edge),
              Vec3(-half - o.pitch - 0.5 * o.big_edge, 0.0, 0.5 * o.big_edge));
  for (int row = 0; row < o.rows; ++row) {
    for (int column = 0; column < o.rows; ++column) {
      builder.box("small/" + std::to_string(row) + "/" + std::to_string(column),
                  Vec3::Constant(o.edge), cube(o.edge),
                  Vec3(o.pitch * row - half, o.pitch * column - half, 0.5 * o.edge));
    }
  }
  return builder.build(options, o.friction);
}

std::unique_ptr<User> PileScenario::make_user(std::size_t user, Controls& controls,
                                              const UserOptions& options) const {
  require_user(user);
  Random random(derived_seed(options.seed, 19));
  const double side = user == 0 ? -1.0 : 1.0;
  const double way = options_.pitch * options_.rows + options_.big_edge;
  std::vector<HandTask> tasks;
  tasks.push_back(roll(options_, controls.scene(), side, kStart + random.uniform(-0.1, 0.1), way));
  tasks.push_back(roll(options_, controls.scene(), side, kBack + random.uniform(-0.1, 0.1), -way));
  return std::make_unique<ScriptedUser>(controls, options, std::move(tasks));
}

std::unique_ptr<Referee> PileScenario::make_referee(const Scene& scene) const {
  return std::make_unique<PileReferee>(options_, scene);
}

Achievement PileScenario::achievement(const Outcome& outcome) const {
  const auto moved = static_cast<std::size_t>(value_of(outcome, "displaced"));
  const std::string rolled = length_words(value_of(outcome, "rolled_m"));
  return {"rolled one big cube by " + rolled + " and moved " + count_words(moved, "small cube"),
          "small cubes moved", std::to_string(moved)};
}

}  // namespace tandem::demos
