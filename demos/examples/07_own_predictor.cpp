// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A custom predictor. A ball in free flight follows its parabola, which Euler's prediction misses
// by g age^2 / 2.
#include <cmath>
#include <cstdio>
#include <memory>

#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/solver.h"

using namespace tandem;

constexpr double kLatency = 0.1;  // s, one way

/// Position, orientation and velocity by formula. Predictions are relative to the newest state of
/// the own copy. One object serves all bodies, so it keeps no state.
class Parabola final : public consensus::Predictor {
 public:
  consensus::Prediction predict(const consensus::StateUpdate& update,
                                const consensus::MotionHistory& own,
                                const consensus::PredictionContext& context) const override {
    const double age = 1e-9 * static_cast<double>(context.now - update.stamp);  // s
    const consensus::MotionSample here = own.newest();
    consensus::Prediction said;
    said.translation = update.pose.position + age * update.twist.linear +
                       0.5 * age * age * context.gravity - here.pose.position;
    said.rotation = pbd::rotation_between(
        here.pose.orientation, pbd::rotated(update.pose.orientation, age * update.twist.angular));
    said.twist.linear = update.twist.linear + age * context.gravity - here.twist.linear;
    said.twist.angular = update.twist.angular - here.twist.angular;
    return said;
  }
};

/// The largest distance between the predicted ball and its owner's.
class Judge final : public consensus::PeerObserver {
 public:
  Judge(const pbd::World& world, pbd::BodyId ball) : world_(world), ball_(ball) {}
  void on_estimate(const consensus::EstimateEvent& event) override {
    worst = std::fmax(worst, (event.position - world_.pose(ball_).position).norm());
    oldest = std::fmax(oldest, event.age);
  }
  double worst = 0.0;   // m
  double oldest = 0.0;  // s

 private:
  const pbd::World& world_;
  pbd::BodyId ball_;
};

/// Peer 1's ball flies for a second; returns its errors at peer 2.
Judge fly(const consensus::PeerOptions& options) {
  constexpr consensus::SessionTime kStep = 16'666'667;  // ns
  consensus::SessionTime now = 1'000'000'000;
  consensus::VirtualNetwork network({.latency = kLatency}, 1, now);
  consensus::Transport* const transports[2] = {&network.transport(1), &network.transport(2)};
  pbd::World worlds[2];
  pbd::Solver solver;
  consensus::Peer peers[2] = {{worlds[0], *transports[0]}, {worlds[1], *transports[1], options}};
  pbd::BodyId balls[2];
  for (int k = 0; k < 2; ++k) {
    balls[k] = worlds[k].add_body({.twist = {.linear = pbd::Vec3(3.0, 0.0, 5.0)}});
    peers[k].share({.id = consensus::SharedId::from_name("ball"), .body = balls[k], .owner = {1}});
  }
  Judge judge(worlds[0], balls[0]);
  peers[1].set_observer(&judge);
  for (int i = 0; i < 60; ++i) {
    for (int k = 1; k >= 0; --k) {  // the second one receives before the first one moves on
      peers[k].before_step(now);
      solver.step(worlds[k], 1e-9 * static_cast<double>(kStep));
    }
    now += kStep;
    network.advance_to(now);
    for (consensus::Peer& peer : peers) peer.after_step(now);
  }
  return judge;
}

int main() {
  const Judge euler = fly({.predictor = consensus::PredictorKind::Euler});
  const Judge own = fly({.own_predictor = std::make_shared<Parabola>()});
  const double formula = 0.5 * 9.81 * euler.oldest * euler.oldest;
  std::printf("states up to %.1f ms old: Euler misses by %.4f m (g age^2 / 2 = %.4f), own %.2g m\n",
              1e3 * euler.oldest, euler.worst, formula, own.worst);
  // The solver's substeps start a parabola up to a quarter of a step early: at most g age h / 8.
  const double early = 9.81 * euler.oldest / 60.0 / 8.0;
  return std::abs(euler.worst - formula) < 1.01 * early && own.worst < 1.01 * early ? 0 : 1;
}
