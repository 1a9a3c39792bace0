// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cost.h"

#include <cstddef>
#include <cstdio>
#include <memory>
#include <span>
#include <vector>

#include "measure/clock.h"
#include "scene.h"
#include "tandem/consensus/update.h"

namespace tandem::extreme_bench {
namespace {

using peers_bench::Session;
using peers_bench::Site;

constexpr int kCounts[] = {2, 4, 8, 16};
constexpr int kStacks = 20;
constexpr int kBoxes = 5;
constexpr int kWarmUp = 60;  // steps
constexpr int kRounds = 40;
constexpr int kSteps = 10;  // per round

Copy stacks() {
  CopyBuilder b;
  floor(b);
  for (int i = 0; i < kStacks; ++i) {
    for (int j = 0; j < kBoxes; ++j) {
      box_at(b, {1.0 * (i % 5) - 2.0, 1.0 * (i / 5) - 2.0, kHalf * (2 * j + 1)});
    }
  }
  return b.done();
}

/// One peer, and others that only send: their worlds would share its caches.
struct Crowd {
  explicit Crowd(int count) : peers(count), session({}) {
    consensus::PeerOptions options;
    options.authority_ramp = 0.0;
    session.sites.push_back(
        std::make_unique<Site>(stacks(), session.network.transport(1), options));
    Site& site = *session.sites.front();
    for (std::size_t i = 0; i < site.copy.bodies.size(); ++i) {
      states.push_back({.id = peers_bench::shared_id(i),
                        .pose = site.copy.world->pose(site.copy.bodies[i]),
                        .influence = 0.08F});
    }
    for (int i = 2; i <= peers; ++i) session.network.transport(static_cast<consensus::PeerId>(i));
    site.user = [this](Site& s, double time) { send(s.clock(time)); };
    site.begun = [this](Site&) { start = bench::thread_seconds(); };
    site.stepped = [this](Site&, const pbd::StepReport& report, double) {
      step += bench::thread_seconds() - start;
      targets += report.targets;
    };
  }
  /// Each of the others is slightly displaced.
  void send(consensus::SessionTime now) {
    for (int i = 2; i <= peers; ++i) {
      std::vector<consensus::StateUpdate> moved = states;
      for (consensus::StateUpdate& update : moved) {
        update.pose.position.x() += 1e-3 * i;
        update.stamp = now;
      }
      packet.clear();
      consensus::encode(std::span<const consensus::StateUpdate>(moved), packet);
      session.network.transport(static_cast<consensus::PeerId>(i))
          .post(1, packet, consensus::Delivery::Newest);
    }
    session.network.advance_to(session.network.now());
  }
  void run(int steps) {
    done += steps;
    session.run_until(done / 60.0);
  }
  double agreement() const {
    const consensus::PeerStats& stats = session.sites.front()->peer.stats();
    return stats.parse_s + stats.process_s + stats.aggregate_s;
  }

  int peers;
  Session session;
  std::vector<consensus::StateUpdate> states;
  std::vector<std::byte> packet;
  int done = 0;
  double start = 0.0;
  double step = 0.0;  ///< s
  long targets = 0;
  std::vector<double> step_us, agreement_us;  ///< per body and step, by round
};

}  // namespace

void print_costs() {
  std::vector<std::unique_ptr<Crowd>> crowds;
  for (const int count : kCounts) {
    crowds.push_back(std::make_unique<Crowd>(count));
    crowds.back()->run(kWarmUp);
  }
  constexpr double kEach = 1e6 / (kSteps * kStacks * kBoxes);
  for (int round = 0; round < kRounds; ++round) {
    for (const auto& crowd : crowds) {
      const double agreement = crowd->agreement();
      crowd->step = 0.0;
      crowd->targets = 0;
      crowd->run(kSteps);
      crowd->step_us.push_back(kEach * crowd->step);
      crowd->agreement_us.push_back(kEach * (crowd->agreement() - agreement));
    }
  }
  std::puts("peers,bodies,targets_each_step,step_us,agreement_us");
  for (const auto& crowd : crowds) {
    std::printf("%d,%d,%ld,%.4g,%.4g\n", crowd->peers, kStacks * kBoxes, crowd->targets / kSteps,
                bench::quantile(crowd->step_us, 0.1), bench::quantile(crowd->agreement_us, 0.1));
  }
}

}  // namespace tandem::extreme_bench
