// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "comparison.h"

#include <algorithm>

namespace tandem::bench {
namespace {

constexpr double kSlow = 0.05;  // m/s

}  // namespace

std::string_view to_string(Situation situation) {
  constexpr std::array<std::string_view, kSituations> kNames = {"resting", "touching", "flight",
                                                                "held", "driven"};
  return kNames[static_cast<std::size_t>(situation)];
}

Comparison::Comparison(const std::vector<consensus::SharedId>& bodies) {
  for (std::uint32_t i = 0; i < bodies.size(); ++i) bodies_[bodies[i]] = i;
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    predictors_[k] = consensus::make_predictor(kKinds[k]);
  }
}

void Comparison::on_estimate(const consensus::EstimateEvent& event) {
  const consensus::StateUpdate& update = event.update;
  Trial trial;
  trial.from = event.from;
  trial.body = bodies_.at(update.id);
  trial.time = event.context.now;
  trial.age = 1e-9 * static_cast<double>(trial.time - update.stamp);
  trial.stamped = update.pose.position;
  trial.slow = update.twist.linear.norm() < kSlow;
  if (update.flags.owner_driven) {
    trial.situation = Situation::Driven;
  } else if (update.flags.held) {
    trial.situation = Situation::Held;
  } else if (update.flags.in_contact) {
    trial.situation = Situation::Touching;
  } else {
    trial.situation = Situation::Flight;
  }
  Memories& memories = memories_[{event.from, trial.body}];
  const pbd::Vec3& own = event.own.newest().pose.position;
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    consensus::PredictionContext context = event.context;
    context.memory = &memories[k];
    const pbd::Vec3 moved =
        own + predictors_[k]->predict(update, event.own, context).translation - trial.stamped;
    for (int axis = 0; axis < 3; ++axis) {
      trial.missed[k][static_cast<std::size_t>(axis)] = static_cast<float>(moved[axis]);
    }
  }
  trials_.push_back(trial);
}

void add_errors(const std::vector<Trial>& trials, const std::vector<demos::PeerRecord>& peers,
                Errors& errors) {
  for (const Trial& trial : trials) {
    const auto sender =
        std::find_if(peers.begin(), peers.end(),
                     [&](const demos::PeerRecord& peer) { return peer.id == trial.from; });
    if (sender == peers.end()) continue;
    const auto truth = sender->tracks[trial.body].at(trial.time);
    if (!truth) continue;
    Situation situation = trial.situation;
    if (situation == Situation::Touching && trial.slow && truth->speed < kSlow) {
      situation = Situation::Resting;
    }
    for (std::size_t k = 0; k < kKinds.size(); ++k) {
      const auto& moved = trial.missed[k];
      const pbd::Vec3 predicted = trial.stamped + pbd::Vec3(moved[0], moved[1], moved[2]);
      errors[static_cast<std::size_t>(situation)][k].push_back(
          (predicted - truth->position).norm());
    }
  }
}

}  // namespace tandem::bench
