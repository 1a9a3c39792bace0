// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/ablation.h"

#include <array>
#include <utility>
#include <vector>

#include "tandem/pbd/world.h"

namespace tandem::demos {

namespace {

/// Derives velocities from all motion, as single-channel position-based dynamics does.
class OneChannel final : public Physics {
 public:
  explicit OneChannel(std::unique_ptr<Physics> physics) : physics_(std::move(physics)) {}

  const pbd::StepReport& step(Scene& scene, consensus::Peer& peer, double dt) override {
    report_ = physics_->step(scene, peer, dt);
    if (report_.status != pbd::StepStatus::Ok) return report_;  // the state is not finite
    const double before = scene.world->kinetic_energy();
    for (const SceneBody& shared : scene.bodies) {
      const pbd::Correction done = scene.world->correction(shared.body);
      if (done.translation.isZero(0.0) && done.rotation.isZero(0.0)) continue;
      pbd::Twist twist = scene.world->twist(shared.body);
      twist.linear += done.translation / dt;
      twist.angular += done.rotation / dt;
      scene.world->set_twist(shared.body, twist);
    }
    report_.energy.displacement += scene.world->kinetic_energy() - before;
    return report_;
  }
  const std::vector<std::pair<std::size_t, std::size_t>>* touching() const override {
    return physics_->touching();
  }

 private:
  std::unique_ptr<Physics> physics_;
  pbd::StepReport report_;
};

/// Targets without velocities.
class PlainTargets final : public pbd::TargetSource {
 public:
  explicit PlainTargets(pbd::TargetSource& source) : source_(source) {}

  void collect(const pbd::World& world, double dt, const pbd::SolverOptions& options,
               std::vector<pbd::PoseTarget>& out) override {
    const std::size_t first = out.size();
    source_.collect(world, dt, options, out);
    for (std::size_t i = first; i < out.size(); ++i) {
      pbd::PoseTarget& target = out[i];
      if (target.share >= 1.0) continue;  // owned bodies need no agreement
      target.twist = world.twist(target.body);
    }
  }

 private:
  pbd::TargetSource& source_;
};

}  // namespace

std::string_view to_string(Part part) {
  constexpr std::array<std::string_view, kParts> kNames{"channels", "velocities", "initiative",
                                                        "leading"};
  return kNames[static_cast<std::size_t>(part)];
}

void Ablation::apply(consensus::PeerOptions& options) const {
  if (lacks(Part::Leading)) options.influence.leading = 0.0;
  if (lacks(Part::Initiative)) options.initiative = false;
}

std::unique_ptr<Physics> Ablation::around(std::unique_ptr<Physics> physics) const {
  if (!lacks(Part::Channels)) return physics;
  return std::make_unique<OneChannel>(std::move(physics));
}

std::unique_ptr<pbd::TargetSource> Ablation::around(pbd::TargetSource& source) const {
  if (!lacks(Part::Velocities)) return nullptr;
  return std::make_unique<PlainTargets>(source);
}

}  // namespace tandem::demos
