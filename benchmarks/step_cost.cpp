// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a step costs, stage by stage, with more and more in the scene: bodies alone, contacts,
// targets on all bodies. Ten stacks of ten cubes; the median of several runs, in microseconds.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/solver.h"

namespace {

using namespace tandem;
using pbd::Vec3;

constexpr int kStacks = 10;
constexpr int kHeight = 10;
constexpr int kWarmUp = 120;
constexpr int kSteps = 240;
constexpr int kRuns = 5;

/// Asks every body to stay where it started, as a remote peer in perfect agreement does.
class HoldAll final : public pbd::TargetSource {
 public:
  explicit HoldAll(double share) : share_(share) {}
  void collect(const pbd::World& world, double /*dt*/, std::vector<pbd::PoseTarget>& out) override {
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
  bool contacts;
  double share;  ///< 0 = nothing shared
  pbd::ConsensusForm form = pbd::ConsensusForm::Substep;
};

struct Cost {
  std::array<double, pbd::kStageCount> stage_us{};
  double total_us = 0.0;
};

Cost run(const Case& c) {
  pbd::World world({.gravity = c.contacts ? Vec3(0.0, 0.0, -9.81) : Vec3(Vec3::Zero())});
  collision::CollisionScene shapes;
  HoldAll targets(c.share);
  if (c.contacts) {
    world.set_contact_source(&shapes);
    const auto ground = world.add_body({.type = pbd::BodyType::Static});
    shapes.add(world, {.body = ground, .shape = collision::HalfSpace{}});
  }
  if (c.share > 0.0) world.set_target_source(&targets);
  const collision::Box cube{Vec3::Constant(0.5)};
  const auto properties = collision::mass_properties(cube, 100.0);
  for (int stack = 0; stack < kStacks; ++stack) {
    for (int k = 0; k < kHeight; ++k) {
      const auto body = world.add_body({.pose = {.position = {4.0 * stack, 0.0, 0.5 + k}},
                                        .mass = properties.mass,
                                        .inertia = properties.inertia_l});
      if (c.contacts) shapes.add(world, {.body = body, .shape = cube});
    }
  }
  pbd::Solver solver({.form = c.form});
  for (int i = 0; i < kWarmUp; ++i) (void)solver.step(world, 1.0 / 60.0);
  Cost cost;
  for (int i = 0; i < kSteps; ++i) {
    const pbd::StepReport& report = solver.step(world, 1.0 / 60.0);
    for (int s = 0; s < pbd::kStageCount; ++s) {
      cost.stage_us[static_cast<std::size_t>(s)] +=
          1e6 * report.stage_s[static_cast<std::size_t>(s)] / kSteps;
    }
    cost.total_us += 1e6 * report.total_s() / kSteps;
  }
  return cost;
}

}  // namespace

int main() {
  const std::vector<Case> cases{
      {"bodies alone", false, 0.0},
      {"contacts", true, 0.0},
      {"contacts, targets", true, 0.08},
      {"contacts, targets, once per step", true, 0.08, pbd::ConsensusForm::Step},
  };
  // Interleaved, so that a drift of the machine's speed meets all cases alike.
  std::vector<std::vector<Cost>> runs(cases.size());
  for (int r = 0; r < kRuns; ++r) {
    for (std::size_t i = 0; i < cases.size(); ++i) runs[i].push_back(run(cases[i]));
  }
  std::printf("%d bodies, median of %d runs, us per step\n%-34s%10s", kStacks * kHeight, kRuns, "",
              "total");
  for (const auto name : pbd::kStageNames) std::printf("%10s", std::string(name).c_str());
  std::printf("\n");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    auto& all = runs[i];
    std::sort(all.begin(), all.end(),
              [](const Cost& a, const Cost& b) { return a.total_us < b.total_us; });
    const Cost& median = all[all.size() / 2];
    std::printf("%-34s%10.1f", cases[i].name, median.total_us);
    for (const double us : median.stage_us) std::printf("%10.1f", us);
    std::printf("\n");
  }
  return 0;
}
