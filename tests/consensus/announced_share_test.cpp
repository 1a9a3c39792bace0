// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a peer announces for its own states, and what comes of it.
#include <limits>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::announced_share_test {
namespace {

using namespace testing;

TEST_CASE("announced share: the only holder of a body announces more, its leader the most",
          "[consensus][unit]") {
  const InfluenceOptions options;
  CHECK(announced_share(options, false, false) == options.baseline);
  CHECK(announced_share(options, true, false) == options.held_alone);
  CHECK(announced_share(options, false, true) == options.leading);
  CHECK(announced_share(options, true, true) == options.leading);
  const InfluenceOptions strong{.baseline = 0.9};  // nothing takes from it
  CHECK(announced_share(strong, true, true) == 0.9);
  const InfluenceOptions none{.baseline = 0.0, .held_alone = 0.0};  // no agreement is none
  CHECK(announced_share(none, true, true) == 0.0);
}

/// m: how far two weightless balls, 10 cm apart, still are after `seconds`.
double gap_after(double seconds, const PeerOptions& options, double latency = 0.0) {
  Session session({.latency = latency});
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless);
    site.share(ball(Vec3(0.1 * i, 0.0, 0.0)));
  }
  session.run(seconds);
  return gap(session[0], session[1]);
}

TEST_CASE("announced share: a small one is a small part of a guess, and a weight as good as any",
          "[consensus]") {
  const PeerOptions plain{.authority_ramp = 0.0};
  const double usual = gap_after(0.5, plain);
  CHECK(usual < 0.02);

  PeerOptions weak = plain;
  weak.influence.baseline = 0.001;
  // Weights in a mean, all equally small: they agree as ever. Shares of a gap, where nothing is
  // replayed: at most 30 steps times two peers times 0.1 %.
  CHECK(gap_after(0.5, weak) == Approx(usual).epsilon(1e-6));
  weak.predictor = PredictorKind::Euler;
  CHECK(gap_after(0.5, weak) > 0.09);

  PeerOptions mute = plain;
  mute.influence.baseline = 0.0;
  CHECK(gap_after(0.5, mute) == Approx(0.1).epsilon(1e-12));
}

TEST_CASE("announced share: of a guess it counts no more than is stable, unless that is wanted",
          "[consensus]") {
  PeerOptions options{.predictor = PredictorKind::Euler, .authority_ramp = 0.0};
  options.influence.baseline = 0.45;
  // The first state comes after 117 ms and is used in two steps: 1 / (6 + 2) of the way in each, or
  // 0.45 times 2^-0.2.
  const double limited = gap_after(0.14, options, 0.1);
  options.influence.limits_guesses = false;
  CHECK(gap_after(0.14, options, 0.1) < 0.8 * limited);
}

TEST_CASE("announced share: a peer that announces more is followed more", "[consensus]") {
  // Eleven times the weight: they meet at a twelfth of the way, Eq. 1.
  Session session({.latency = 0.1});
  for (int i = 0; i < 2; ++i) {
    PeerOptions options{.authority_ramp = 0.0};
    options.influence.baseline = share_of_weight(i == 0 ? 0.22 : 0.02);
    options.replay.budget = std::numeric_limits<double>::infinity();
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless);
    site.share(ball(Vec3(0.12 * i, 0.0, 0.0)));
  }
  session.run(4.0);
  CHECK(gap(session[0], session[1]) < 1e-4);
  CHECK(session[0].x().x() == Approx(0.12 / 12.0).epsilon(1e-3));
}

}  // namespace
}  // namespace tandem::consensus::announced_share_test
