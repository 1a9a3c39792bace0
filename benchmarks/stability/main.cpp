// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stable shares by delay: two peers start 5 cm apart, without users. Prints one line of CSV per
// case:
//
//   scheme, scene, share of peer 1, share of peer 2, delay from peer 1 to 2 and back (frames),
//   loss, stable, end / start, peak / start, half-life (frames; -1 = never), speed kept
//
// The difference is the rms over bodies at the same session time. Stable: in the last 4.5 of 15 s
// it is below its start, and below 0.1 mm or its value in the 4.5 s before, since the slowest
// oscillation, the chain's, takes 2.9 s. Speed kept: rms speed in the last 4.5 s, relative to both
// alone; if only one swings at first, both end with half, and 0.707 is kept.
//
//   stability [scheme [scene]]      only these

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "../../demos/session/published_rules.h"
#include "copies/measures.h"
#include "copies/session.h"
#include "scenes.h"

namespace {

using namespace tandem;
using namespace tandem::stability_bench;
using peers_bench::Site;

constexpr double kRate = 60.0;
constexpr int kSteps = 900;
constexpr double kApart = 0.05;  // m

struct Scheme {
  std::string_view name;
  consensus::Coupling coupling;
  bool published;  ///< the paper's prediction
};
constexpr Scheme kSchemes[] = {
    {"one-pass", consensus::Coupling::OnePass, false},
    {"two-step", consensus::Coupling::TwoStep, false},
    {"one-pass-plain", consensus::Coupling::OnePass, true},
    {"two-step-plain", consensus::Coupling::TwoStep, true},
};
constexpr double kShares[] = {0.02, 0.05, 0.1, 0.2, 0.3, 0.5};
constexpr int kDelays[] = {0, 1, 2, 3, 5, 8, 11, 15, 20, 30};

/// Links both ways between the peers.
struct Ways {
  int there = 0, back = 0;  ///< frames, from peer 1 to 2 and from 2 to 1
  double loss = 0.0;
  double jitter = 0.0;  ///< frames
};
/// Asymmetric links, and one with loss and reordering.
constexpr Ways kUneven[] = {{2, 14}, {14, 2}, {2, 30}, {30, 2}, {8, 8, 0.2, 3.0}};

/// @param share  of the gap closed per 1/60 s by this peer with replay; without it the announced
///   share, as published
consensus::PeerOptions options_of(const Scheme& scheme, double share) {
  consensus::PeerOptions options;
  options.coupling = scheme.coupling;
  options.two_step_thresholds = false;
  options.authority_ramp = 0.0;
  options.replay.share = share;
  if (!scheme.published) return options;
  options.influence.baseline = share;
  return consensus::with_published_rules(options);
}

double speed_square(const peers_bench::Copy& copy) {
  double sum = 0.0;
  for (const pbd::BodyId body : copy.bodies) sum += copy.world->twist(body).linear.squaredNorm();
  return sum;
}

/// m^2/s^2: mean of speed_square() over the end, of a single copy.
double speed_square_alone(std::size_t kind, double apart) {
  peers_bench::Copy copy = build(kKinds[kind], apart);
  pbd::Solver solver{{.measure_stages = false}};
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    solver.step(*copy.world, 1.0 / kRate);
    if (k >= 630) sum += speed_square(copy);
  }
  return sum;
}

void run(const Scheme& scheme, std::size_t kind, double share_1, double share_2, const Ways& ways) {
  // Without latency, the state of a step's end is used at the beginning of the next.
  const auto link = [&ways](int delay) {
    return consensus::LinkOptions{.latency = peers_bench::latency_of(delay),
                                  .jitter = ways.jitter / kRate,
                                  .loss = ways.loss};
  };
  peers_bench::Session session(link(ways.there));
  const auto add = [&](consensus::PeerId id, double off, double share) {
    session.sites.push_back(std::make_unique<Site>(
        build(kKinds[kind], off), session.network.transport(id), options_of(scheme, share)));
  };
  add(1, 0.0, share_1);
  add(2, kApart, share_2);
  session.network.set_link(2, 1, link(ways.back));
  const auto difference_now = [&] {
    return peers_bench::apart(session.sites[0]->copy, session.sites[1]->copy);
  };
  const double start = difference_now();
  std::vector<double> difference;
  double squares = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    session.run_until((k + 1) / kRate);
    difference.push_back(difference_now() / start);
    if (k >= 630) {
      for (const auto& site : session.sites) squares += speed_square(site->copy);
    }
  }
  const auto worst = [&](int from, int to) {
    return *std::max_element(difference.begin() + from, difference.begin() + to);
  };
  const double middle = worst(360, 630);
  const double end = worst(630, 900);
  const bool stable =
      std::isfinite(end) && end < 1.0 && (end < 1e-4 / start || end <= 1.05 * middle);
  int half = -1;
  for (int k = 0; k < kSteps && half < 0; ++k) {
    if (worst(k, kSteps) < 0.5) half = k + 1;
  }
  const double alone = speed_square_alone(kind, 0.0) + speed_square_alone(kind, kApart);
  const double kept = alone > 1e-9 ? std::sqrt(squares / alone) : 1.0;
  std::printf("%.*s,%.*s,%g,%g,%d,%d,%g,%d,%.3g,%.3g,%d,%.3g\n",
              static_cast<int>(scheme.name.size()), scheme.name.data(),
              static_cast<int>(kKindNames[kind].size()), kKindNames[kind].data(), share_1, share_2,
              ways.there, ways.back, ways.loss, stable ? 1 : 0, end, worst(0, kSteps), half, kept);
}

}  // namespace

int main(int argc, char** argv) {
  std::puts(
      "scheme,scene,share_1,share_2,delay_frames,delay_back_frames,loss,stable,end,peak,"
      "half_life_frames,speed_kept");
  for (const Scheme& scheme : kSchemes) {
    if (argc > 1 && scheme.name != argv[1]) continue;
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      if (argc > 2 && kKindNames[kind] != argv[2]) continue;
      for (const int delay : kDelays) {
        for (const double share : kShares) run(scheme, kind, share, share, {delay, delay});
        run(scheme, kind, 0.02, 0.5, {delay, delay});
        run(scheme, kind, 0.5, 0.02, {delay, delay});
      }
      for (const Ways& ways : kUneven) {
        for (const double share : kShares) run(scheme, kind, share, share, ways);
      }
    }
  }
  return 0;
}
