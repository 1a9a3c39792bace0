// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <string>
#include <string_view>
#include <utility>

#include "demos/scenes/random.h"
#include "rollback/session.h"
#include "scenes/cliff.h"
#include "scenes/pile.h"
#include "scenes/scenario_list.h"

namespace tandem::rollback_bench {

namespace {

using pbd::Vec3;

constexpr double kEdge = 0.1;  // m

/// Up to six people around one heap of cubes: each moves one cube after the other, whoever else
/// uses it.
class Table final : public demos::Scenario {
 public:
  explicit Table(std::size_t people) : Scenario("table", people) {}

  demos::Scene build(const demos::SceneOptions& options) const override {
    constexpr int kSide = 3;         // stacks along each side
    constexpr int kHeight = 2;       // cubes in each
    constexpr double kPitch = 0.16;  // m, between stacks
    demos::SceneBuilder builder;
    for (int i = 0; i < kSide * kSide * kHeight; ++i) {
      const int stack = i / kHeight;
      builder.box("cube/" + std::to_string(i), Vec3::Constant(kEdge), 0.3,
                  Vec3(kPitch * (stack % kSide - 1), kPitch * (stack / kSide - 1),
                       kEdge * (i % kHeight + 0.5)));
    }
    return builder.build(options, 0.55);
  }

  std::unique_ptr<demos::User> make_user(std::size_t user, demos::Controls& controls,
                                         const demos::UserOptions& options) const override {
    require_user(user);
    constexpr double kPeriod = 2.5;  // s per cube
    demos::Random random(demos::derived_seed(options.seed, 23));
    std::vector<demos::HandTask> tasks;
    for (double start = 1.0; start < options.seconds; start += kPeriod) {
      const double late = random.uniform(0.0, 0.3);
      const std::size_t body = random.below(controls.scene().bodies.size());
      const double x = random.uniform(-0.25, 0.25);
      const Vec3 to(x, random.uniform(-0.25, 0.25), 0.5 * kEdge);
      const auto plan = [&controls, body, to]() -> std::optional<demos::HandPlan> {
        const Vec3 from = controls.scene().pose(body).position;
        demos::HandPath path(0.0, from);
        path.wait(0.2).move_by(Vec3(0.0, 0.0, 0.15), 0.5);
        path.move_to(Vec3(to.x(), to.y(), from.z() + 0.15), 0.7).move_to(to, 0.6);
        const Vec3 spread(0.4 * kEdge, 0.4 * kEdge, 0.0);
        const double load = controls.scene().mass(body);
        return demos::HandPlan{body, demos::GripSpec::for_load(load, spread), path};
      };
      tasks.push_back({start + late, plan});
    }
    return std::make_unique<demos::ScriptedUser>(controls, options, std::move(tasks));
  }
};

}  // namespace

std::unique_ptr<demos::Scenario> make_scenario(const std::string& name, int people,
                                               const std::string& variant) {
  if (name == "piano") return demos::make_scenario(name, variant);
  if (!variant.empty()) return nullptr;
  if (name == "cliff") return std::make_unique<demos::CliffScenario>(200);
  if (name == "pile") {
    return std::make_unique<demos::PileScenario>(demos::PileOptions{.rows = 8});
  }
  if (name == "table") return std::make_unique<Table>(static_cast<std::size_t>(people));
  return demos::make_scenario(name, "");
}

}  // namespace tandem::rollback_bench
