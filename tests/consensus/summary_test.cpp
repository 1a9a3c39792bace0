// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One state instead of many.
#include "tandem/consensus/summary.h"

#include <vector>

#include "consensus/peer_fixture.h"
#include "support/catch.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/random.h"

namespace tandem::consensus::summary_test {
namespace {

using namespace testing;

StateUpdate state(pbd::SplitMix64& dice, double share) {
  const auto vector = [&](double size) {
    return Vec3(dice.uniform(-size, size), dice.uniform(-size, size), dice.uniform(-size, size));
  };
  StateUpdate out{.id = kBody, .influence = static_cast<float>(share), .stamp = kStart};
  out.pose = {vector(1.0), pbd::rotated(Quat::Identity(), vector(0.1))};
  out.twist = {vector(2.0), vector(2.0)};
  return out;
}

pbd::PoseTarget target_of(std::span<const StateUpdate> states) {
  std::vector<PeerEstimate> estimates;
  for (const StateUpdate& each : states) {
    estimates.push_back({.peer = estimates.size() + 1,
                         .pose = each.pose,
                         .twist = each.twist,
                         .share = static_cast<double>(each.influence)});
  }
  pbd::PoseTarget out;
  REQUIRE(fuse({}, estimates, out));
  return out;
}

TEST_CASE("summary: a receiver comes to the same target by one fused state as by all of them",
          "[consensus]") {
  pbd::SplitMix64 dice(4);
  for (int i = 0; i < 200; ++i) {
    std::vector<StateUpdate> all;
    const std::uint64_t count = 1 + dice.below(12);
    double weight = 0.0;
    for (std::uint64_t k = 0; k < count; ++k) {
      all.push_back(state(dice, dice.uniform(0.01, 0.3)));
      weight += weight_of_share(static_cast<double>(all.back().influence));
    }
    const auto fused = fuse(all);
    REQUIRE(fused.has_value());
    CHECK(weight_of_share(static_cast<double>(fused->influence)) == Approx(weight).epsilon(1e-5));
    // With somebody else who was not fused, as well.
    std::vector<StateUpdate> other{state(dice, 0.1)};
    std::vector<StateUpdate> one = other;
    one.push_back(*fused);
    all.push_back(other[0]);
    const pbd::PoseTarget apart = target_of(all);
    const pbd::PoseTarget together = target_of(one);
    CHECK((apart.pose.position - together.pose.position).norm() < 1e-5);
    CHECK((apart.twist.linear - together.twist.linear).norm() < 1e-5);
    CHECK((apart.twist.angular - together.twist.angular).norm() < 1e-5);
    CHECK((apart.rotation_error - together.rotation_error).norm() < 2e-3);  // a mean of means
    CHECK(apart.share == Approx(together.share).epsilon(1e-5));
  }
}

TEST_CASE("summary: leaders count alone, owners own, mixed bodies or times are refused",
          "[consensus]") {
  pbd::SplitMix64 dice(5);
  std::vector<StateUpdate> all{state(dice, 0.1), state(dice, 0.1), state(dice, 0.1)};
  CHECK_FALSE(fuse(std::span<const StateUpdate>()).has_value());
  all[1].flags.leads = true;
  all[1].influence = 0.8F;
  const auto led = fuse(all);
  REQUIRE(led.has_value());
  CHECK(led->flags.leads);
  CHECK(led->pose.position == all[1].pose.position);
  all[1].flags.leads = false;
  all[1].influence = 1.0F;
  CHECK(fuse(all)->influence == 1.0F);
  CHECK((fuse(all)->pose.position - all[1].pose.position).norm() < 1e-12);
  all[1].stamp += 1;
  CHECK_FALSE(fuse(all).has_value());
  all[1] = state(dice, 0.0);
  CHECK_FALSE(fuse(std::span(all).subspan(1, 1)).has_value());
}

TEST_CASE("summary: a fused state has the weight of all peers, and their pose", "[consensus]") {
  Session session;
  for (PeerId id = 1; id <= 4; ++id) {
    session.add(id, 0.0, {}, kWeightless).share(ball(Vec3::Zero(), Vec3(0.5, 0.0, 0.0)));
  }
  session.run(3.0);
  const auto fused = session[0].peer->fused(kBody);
  REQUIRE(fused.has_value());
  CHECK((fused->pose.position - session[0].x()).norm() < 1e-3);
  // Four baselines of 0.08.
  CHECK(static_cast<double>(fused->influence) ==
        Approx(share_of_weight(4.0 * weight_of_share(0.08))).epsilon(1e-6));
  CHECK(check(*fused).ok());
  CHECK_FALSE(session[0].peer->fused(SharedId::from_name("nothing")).has_value());
}

}  // namespace
}  // namespace tandem::consensus::summary_test
