// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Cost of a step by stage, from bodies alone to everything at once. A hundred bodies; the fastest
// of several runs, in microseconds, and the stages that ran and that were skipped. A stage without
// a number did not run.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace {

using namespace tandem;
using pbd::Vec3;

constexpr int kStacks = 10;
constexpr int kHeight = 10;
constexpr int kWarmUp = 120;
constexpr int kSteps = 120;
constexpr int kRuns = 5;

/// Targets every body's start, as from a remote peer in perfect agreement.
class HoldAll final : public pbd::TargetSource {
 public:
  explicit HoldAll(double share) : share_(share) {}
  void collect(const pbd::World& world, double /*dt*/, const pbd::SolverOptions& /*options*/,
               std::vector<pbd::PoseTarget>& out) override {
    for (std::uint32_t i = 0; i < world.slot_count(); ++i) {
      const pbd::BodyId id = world.body_at(i);
      if (!id.valid() || world.props(id).type != pbd::BodyType::Dynamic) continue;
      pbd::PoseTarget target{
          .body = id, .pose = world.pose(id), .twist = world.twist(id), .share = share_};
      target.pose.position.x() += 1e-4;  // a difference to work on
      out.push_back(target);
    }
  }

 private:
  double share_;
};

struct Case {
  const char* name;
  bool contacts = false;
  bool cubes = true;  ///< otherwise scattered spheres: cubes stand in stacks
  double friction = 0.0;
  double restitution = 0.0;
  bool spin = false;
  bool joints = false;  ///< each body to the one above
  double share = 0.0;   ///< 0 = nothing shared
  double sleep_after = 0.0;
};

struct Cost {
  std::array<double, pbd::kStageCount> stage_us{};
  std::array<bool, pbd::kStageCount> ran{};
  double total_us = 0.0;
  std::string description;
};

Cost run(const Case& c) {
  pbd::World world({.gravity = c.contacts ? Vec3(0.0, 0.0, -9.81) : Vec3(Vec3::Zero())});
  collision::CollisionScene shapes;
  HoldAll targets(c.share);
  const collision::Material material{.friction = c.friction, .restitution = c.restitution};
  const auto add = [&](const pbd::BodyDef& def, const collision::Shape& shape) {
    const pbd::BodyId id = world.add_body(def);
    collision::ColliderDef collider;
    collider.body = id;
    collider.shape = shape;
    collider.material = material;
    if (c.contacts) shapes.add(world, collider);
    return id;
  };
  if (c.contacts) {
    world.set_contact_source(&shapes);
    add({.type = pbd::BodyType::Static}, collision::HalfSpace{});
  }
  if (c.share > 0.0) world.set_target_source(&targets);
  const collision::Shape shape = c.cubes ? collision::Shape(collision::Box{Vec3::Constant(0.5)})
                                         : collision::Shape(collision::Sphere{0.5});
  const auto properties = collision::mass_properties(shape, 100.0);
  auto& joints = world.add_block<pbd::JointBlock>();
  for (int stack = 0; stack < kStacks; ++stack) {
    pbd::BodyId below;
    for (int k = 0; k < kHeight; ++k) {
      const double lean = c.cubes ? 0.0 : 0.1 * (k % 3);  // spheres roll off each other
      pbd::BodyDef def;
      def.pose.position = Vec3((c.cubes ? 4.0 : 1.2) * stack + lean, 0.7 * lean, 0.5 + k);
      def.mass = properties.mass;
      def.inertia = properties.inertia;
      if (c.spin) def.twist.angular = Vec3(0.3, 0.2, 1.0);
      const pbd::BodyId id = add(def, shape);
      const Vec3 between = def.pose.position - Vec3(0.0, 0.0, 0.5);
      if (c.joints && k > 0) joints.add(world, pbd::ball_joint_at(world, below, id, between));
      below = id;
    }
  }
  pbd::Solver solver({.sleep_after = c.sleep_after});
  for (int i = 0; i < kWarmUp; ++i) (void)solver.step(world, 1.0 / 60.0);
  Cost cost;
  for (int i = 0; i < kSteps; ++i) {
    const pbd::StepReport& report = solver.step(world, 1.0 / 60.0);
    for (std::size_t s = 0; s < pbd::kStageCount; ++s) {
      cost.stage_us[s] += 1e6 * report.stage_s[s] / kSteps;
      cost.ran[s] = cost.ran[s] || report.ran[s];
    }
    cost.total_us += 1e6 * report.total_s() / kSteps;
  }
  cost.description = solver.describe();
  return cost;
}

}  // namespace

int main() {
  const std::vector<Case> cases{
      {.name = "free bodies"},
      {.name = "and spinning", .spin = true},
      {.name = "and joined", .spin = true, .joints = true},
      {.name = "spheres, smooth", .contacts = true, .cubes = false},
      {.name = "spheres, rough, bouncing",
       .contacts = true,
       .cubes = false,
       .friction = 0.5,
       .restitution = 0.3},
      {.name = "stacks of cubes", .contacts = true, .friction = 0.5},
      {.name = "the same, asleep", .contacts = true, .friction = 0.5, .sleep_after = 0.5},
      {.name = "the same, shared", .contacts = true, .friction = 0.5, .share = 0.08},
      {.name = "everything",
       .contacts = true,
       .friction = 0.5,
       .restitution = 0.3,
       .joints = true,
       .share = 0.08},
  };
  // Interleaved, so that a drift of the machine's speed affects all cases.
  std::vector<std::vector<Cost>> runs(cases.size());
  for (int r = 0; r < kRuns; ++r) {
    for (std::size_t i = 0; i < cases.size(); ++i) runs[i].push_back(run(cases[i]));
  }
  std::printf("%d bodies, fastest of %d runs, us per step\n%-34s%10s", kStacks * kHeight, kRuns, "",
              "total");
  for (const auto name : pbd::kStageNames) std::printf("%10s", std::string(name).c_str());
  std::printf("\n");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    auto& all = runs[i];
    std::sort(all.begin(), all.end(),
              [](const Cost& a, const Cost& b) { return a.total_us < b.total_us; });
    const Cost& best = all.front();
    std::printf("%-34s%10.1f", cases[i].name, best.total_us);
    for (std::size_t k = 0; k < pbd::kStageCount; ++k) {
      if (best.ran[k]) {
        std::printf("%10.1f", best.stage_us[k]);
      } else {
        std::printf("%10s", "-");
      }
    }
    std::printf("\n");
  }
  for (std::size_t i = 0; i < cases.size(); ++i) {
    std::printf("\n%s\n%s", cases[i].name, runs[i].front().description.c_str());
  }
  return 0;
}
