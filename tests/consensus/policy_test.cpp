// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/policy.h"

#include <limits>
#include <stdexcept>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::policy_test {
namespace {

using namespace testing;

TEST_CASE("policy: the default chains are the rules of influence.h", "[consensus][unit]") {
  const InfluenceOptions options;
  const PolicyChain hearing = default_hearing(options);
  for (const double announced : {0.0, 0.05, 0.08, 0.3, 0.5, 1.0}) {
    for (const double age : {-0.01, 0.0, 0.02, 0.123, 0.5, 0.99, 1.01}) {
      CHECK(hearing.apply(announced, {.age = age}) == effective_share(options, announced, age));
    }
  }
  const PolicyChain announcement = default_announcement(options);
  CHECK(announcement.apply(0.0, {}) == options.baseline);
  CHECK(announcement.apply(0.0, {.confidence = 0.25}) == 0.25 * options.baseline);
  CHECK(announcement.apply(0.0, {.held_alone = true}) == options.held_alone);
  CHECK(announcement.apply(0.0, {.owned = true, .held_alone = true}) == 0.0);
  CHECK(announcement.apply(0.0, {.owned = true, .sender_owns = true, .confidence = 0.1}) == 1.0);
}

TEST_CASE("policy: rules compose in their order", "[consensus][unit]") {
  PolicyChain chain;
  CHECK(chain.empty());
  CHECK(chain.apply(0.3, {}) == 0.3);
  chain.then(baseline(0.4)).then(damped_start(2.0)).then(modelled_error(0.01));
  CHECK_FALSE(chain.empty());
  // A quarter of the time, and an error as large as the reference: half.
  CHECK(chain.apply(0.0, {.heard_for = 0.5, .variance = 1e-4}) == Approx(0.05).epsilon(1e-12));
  CHECK(chain.apply(0.0, {}) == 0.4);  // nothing is known against it
  CHECK(chain.apply(0.0, {.heard_for = -1.0}) == 0.0);
  // Three times the error: a tenth.
  CHECK(chain.apply(0.0, {.variance = 9e-4}) == Approx(0.04).epsilon(1e-12));
}

TEST_CASE("policy: who leads announces more", "[consensus][unit]") {
  const InfluenceOptions options;
  const PolicyChain announcement = default_announcement(options);
  CHECK(announcement.apply(0.0, {.leads = 1.0}) == options.leading);
  CHECK(announcement.apply(0.0, {.leads = 0.9}) == options.baseline);
  InfluenceOptions none;
  none.baseline = 0.0;  // no agreement is none
  CHECK(default_announcement(none).apply(0.0, {.leads = 1.0}) == 0.0);
  // Of a leader as of others not above what decays with age, 2^-1 at the half life.
  CHECK(default_hearing(options).apply(0.8, {.age = options.half_life}) ==
        Approx(0.4).epsilon(1e-12));
  CHECK_THROWS_AS(raised_while_leading(1.5), std::invalid_argument);
}

TEST_CASE("policy: owners are beyond the rules of acceptance", "[consensus][unit]") {
  const InfluenceContext context{.heard_for = 0.0, .variance = 1.0};
  for (const auto& policy : {damped_start(1.0), modelled_error(0.01), sleeping_threshold()}) {
    CHECK(policy->apply(1.0, context) == 1.0);
    CHECK(policy->apply(0.1, context) < 0.1);
  }
}

TEST_CASE("policy: the sleeping threshold wants all differences small", "[consensus][unit]") {
  const auto policy = sleeping_threshold();
  const InfluenceContext small{
      .distance = 9e-4, .angle = 0.017, .speed = 9e-3, .angular_speed = 9e-3};
  CHECK(policy->apply(0.1, small) == 0.0);
  for (int i = 0; i < 4; ++i) {
    InfluenceContext one = small;
    (i == 0 ? one.distance : i == 1 ? one.angle : i == 2 ? one.speed : one.angular_speed) = 0.02;
    CHECK(policy->apply(0.1, one) == 0.1);
  }
}

TEST_CASE("policy: what makes no sense is refused by name", "[consensus][fault]") {
  CHECK_THROWS_WITH(baseline(1.5), "baseline: share = 1.500000 breaks the rule: 0 to 1");
  CHECK_THROWS_AS(raised_while_held_alone(-0.1), std::invalid_argument);
  CHECK_THROWS_AS(age_decay(0.0, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(modelled_error(0.0), std::invalid_argument);
  CHECK_THROWS_AS(damped_start(-1.0), std::invalid_argument);
  CHECK_THROWS_AS(sleeping_threshold({.speed = 0.0}), std::invalid_argument);
  CHECK_THROWS_AS(PolicyChain().then(nullptr), std::invalid_argument);
}

/// m: how far two weightless balls, 10 cm apart, still are after `seconds`.
double gap_after(double seconds, const PeerOptions& options) {
  Session session;
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless);
    site.share(ball(Vec3(0.1 * i, 0.0, 0.0)));
  }
  session.run(seconds);
  return gap(session[0], session[1]);
}

TEST_CASE("policy: peers go by the rules they were given", "[consensus]") {
  const PeerOptions plain{.authority_ramp = 0.0};
  const double usual = gap_after(0.5, plain);
  CHECK(usual < 0.02);

  PeerOptions weak = plain;
  weak.announcement.then(baseline(0.001));
  // Weights in a mean, all equally small: they agree as ever. Shares of a gap, where nothing is
  // replayed: at most 30 steps times two peers times 0.1 %.
  CHECK(gap_after(0.5, weak) == Approx(usual).epsilon(1e-6));
  weak.predictor = PredictorKind::SecondOrder;
  CHECK(gap_after(0.5, weak) > 0.09);

  PeerOptions damped = plain;
  damped.acceptance.then(damped_start(5.0));
  CHECK(gap_after(0.5, damped) > 2.0 * usual);

  PeerOptions sleepy = plain;
  sleepy.acceptance.then(sleeping_threshold({.distance = 0.05}));
  CHECK(gap_after(3.0, sleepy) == Approx(0.05).margin(0.01));
  CHECK(gap_after(3.0, plain) < 1e-3);

  PeerOptions deaf = plain;
  deaf.hearing.then(baseline(0.0));
  CHECK(gap_after(0.5, deaf) == Approx(0.1).epsilon(1e-12));
}

TEST_CASE("policy: who announces more is followed more", "[consensus]") {
  // Eleven times the weight: they meet at a twelfth of the way, Eq. 1.
  Session session({.latency = 0.1});
  for (int i = 0; i < 2; ++i) {
    PeerOptions options{.authority_ramp = 0.0};
    options.announcement.then(baseline(share_of_weight(i == 0 ? 0.22 : 0.02)));
    options.replay.budget = std::numeric_limits<double>::infinity();
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless);
    site.share(ball(Vec3(0.12 * i, 0.0, 0.0)));
  }
  session.run(4.0);
  CHECK(gap(session[0], session[1]) < 1e-4);
  // Weights of announced shares that have decayed for as long as the news is old.
  const auto weight = [](double announced) {
    return weight_of_share(effective_share({}, share_of_weight(announced), 0.1));
  };
  const double part = weight(0.02) / (weight(0.02) + weight(0.22));
  CHECK(part == Approx(1.0 / 12.0).epsilon(0.05));
  CHECK(session[0].x().x() == Approx(0.12 * part).epsilon(1e-3));
}

}  // namespace
}  // namespace tandem::consensus::policy_test
