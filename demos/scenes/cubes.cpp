// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/cubes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/cubes_users.h"
#include "scenes/words.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

/// Distance that the plate was carried, and the cubes still on it.
class CubesReferee final : public Referee {
 public:
  CubesReferee(const CubesOptions& cubes, const Scene& scene)
      : cubes_(cubes), plate_(scene.index_of("plate")) {}
  void watch(const Scene& scene, double /*time*/) override {
    const pbd::Vec3 moved = scene.pose(plate_).position - scene.bodies[plate_].start;
    lifted_ = std::max(lifted_, moved.z());
    carried_ = std::max(carried_, std::abs(moved.y()));
  }
  Outcome outcome(const Scene& scene) const override {
    const pbd::Pose& plate = scene.pose(plate_);
    double on_plate = 0.0, standing = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (!scene.bodies[i].name.starts_with("cube/")) continue;
      const pbd::Vec3 local = plate.to_local(scene.pose(i).position);
      const bool above = local.z() > 0.0 && std::abs(local.x()) < 0.5 * cubes_.plate.x() &&
                         std::abs(local.y()) < 0.5 * cubes_.plate.y();
      if (!above) continue;
      on_plate += 1.0;
      const pbd::Vec3 place = scene.bodies[i].start - scene.bodies[plate_].start;
      if ((local - place).norm() < 0.5 * cubes_.edge) standing += 1.0;
    }
    return {{"plate_lifted_m", lifted_},
            {"plate_carried_m", carried_},
            {"cubes_on_plate", on_plate},
            {"cubes_in_stacks", standing}};
  }

 private:
  CubesOptions cubes_;
  std::size_t plate_;
  double lifted_ = 0.0;   ///< m
  double carried_ = 0.0;  ///< m
};

bool positive(double value) { return std::isfinite(value) && value > 0.0; }

}  // namespace

void CubesOptions::validate() const {
  pbd::detail::require(stacks >= 2 && stacks <= 100, "CubesOptions", "stacks", stacks,
                       "from 2 to 100");
  pbd::detail::require(height >= 2 && height <= 100, "CubesOptions", "height", height,
                       "from 2 to 100");
  pbd::detail::require(positive(edge), "CubesOptions", "edge", edge, "finite and > 0 m");
  pbd::detail::require(positive(cube_mass), "CubesOptions", "cube_mass", cube_mass,
                       "finite and > 0 kg");
  pbd::detail::require(positive(plate_mass), "CubesOptions", "plate_mass", plate_mass,
                       "finite and > 0 kg");
  for (int axis = 0; axis < 3; ++axis) {
    pbd::detail::require(positive(plate[axis]), "CubesOptions", "plate", plate[axis],
                         "each edge finite and > 0 m");
  }
  pbd::detail::require(plate.x() >= 2.0 * edge * stacks, "CubesOptions", "plate", plate.x(),
                       "two edges of cubes for each stack");
  pbd::detail::require(std::isfinite(friction) && friction >= 0.0, "CubesOptions", "friction",
                       friction, "finite and >= 0");
}

CubesScenario::CubesScenario(const CubesOptions& options)
    : Scenario("cubes", 2), options_(options) {
  options_.validate();
}

Scene CubesScenario::build(const SceneOptions& options) const {
  const CubesOptions& o = options_;
  const pbd::Vec3 cube = pbd::Vec3::Constant(o.edge);
  SceneBuilder builder;
  builder.box("plate", o.plate, o.plate_mass, pbd::Vec3(0.0, 0.0, 0.5 * o.plate.z()));
  const double spacing = o.plate.x() / o.stacks;
  for (int stack = 0; stack < o.stacks; ++stack) {
    const double x = spacing * (stack + 0.5) - 0.5 * o.plate.x();
    for (int level = 0; level < o.height; ++level) {
      const double z = o.plate.z() + o.edge * (level + 0.5);
      builder.box("cube/" + std::to_string(stack) + "/" + std::to_string(level), cube, o.cube_mass,
                  pbd::Vec3(x, 0.0, z));
    }
  }
  // Away from the plate, its rubble and the hands.
  const pbd::Vec3 pillar(0.5 * o.plate.x() + 5.0 * o.edge, -0.5 * o.plate.y(), 0.0);
  for (int level = 0; level < o.height; ++level) {
    builder.box("pillar/" + std::to_string(level), cube, o.cube_mass,
                pillar + pbd::Vec3(0.0, 0.0, o.edge * (level + 0.5)));
  }
  return builder.build(options, o.friction);
}

std::unique_ptr<User> CubesScenario::make_user(std::size_t user, Controls& controls,
                                               const UserOptions& options) const {
  require_user(user);
  return std::make_unique<ScriptedUser>(controls, options,
                                        cubes_tasks(user, options_, controls.scene(), options));
}

std::unique_ptr<Referee> CubesScenario::make_referee(const Scene& scene) const {
  return std::make_unique<CubesReferee>(options_, scene);
}

std::string CubesScenario::fault(const Scene& scene) const {
  constexpr double kMaxShift = 5e-3;
  constexpr double kMaxTilt = 0.035;
  for (const SceneBody& body : scene.bodies) {
    if (!body.name.starts_with("pillar/")) continue;
    const pbd::Pose& pose = scene.pose(body);
    const double shift = (pose.position - body.start).norm();
    const double tilt = std::acos(std::min(1.0, (pose.orientation * pbd::Vec3::UnitZ()).z()));
    if (!(shift <= kMaxShift) || !(tilt <= kMaxTilt)) {
      return body.name + " of the undisturbed stack has moved by " + std::to_string(shift) +
             " m and tilted by " + std::to_string(tilt) + " rad";
    }
  }
  return {};
}

Achievement CubesScenario::achievement(const Outcome& outcome) const {
  const std::string carried = length_words(value_of(outcome, "plate_carried_m"));
  const auto on = static_cast<std::size_t>(value_of(outcome, "cubes_on_plate"));
  return {"carried one plate with " + count_words(on, "cube") + " on it by " + carried,
          "plate carried by", carried, value_of(outcome, "plate_carried_m") > options_.edge};
}

}  // namespace tandem::demos
