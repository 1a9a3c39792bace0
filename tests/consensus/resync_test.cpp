// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What has come apart for good is put together as a whole, at those who give way.
#include <algorithm>
#include <cmath>

#include "consensus/crowd_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"

namespace tandem::consensus::resync_test {
namespace {

using namespace testing;

/// Two balls on a rod, upright on either side of a post, and both against it: no way around it.
void build_rod(Member& member, double x) {
  member.world->set_gravity(Vec3::Zero());
  pbd::BodyDef post;
  post.type = pbd::BodyType::Static;
  post.pose.position = Vec3::Zero();
  const pbd::BodyId fixed = member.world->add_body(post);
  const pbd::BodyId a = member.share("a", ball({x, 0.0, -0.15}));
  const pbd::BodyId b = member.share("b", ball({x, 0.0, 0.15}));
  auto& joints = member.world->add_block<pbd::JointBlock>();
  joints.add(*member.world, pbd::fixed_joint_at(*member.world, a, b, {x, 0.0, 0.0}));
  member.contacts->ball_on_ball(fixed, 0.2, a, kBallRadius, {.friction = 0.0});
  member.contacts->ball_on_ball(fixed, 0.2, b, kBallRadius, {.friction = 0.0});
  member.world->set_contact_source(member.contacts.get());
}

/// Passes a peer's targets on, and looks how far they are from bodies that were just put somewhere.
class TargetsOfPlaced final : public pbd::TargetSource {
 public:
  explicit TargetsOfPlaced(Peer& peer) : peer_(peer) {}
  double farthest = 0.0;  ///< m

  void collect(const pbd::World& world, double dt, const pbd::SolverOptions& options,
               std::vector<pbd::PoseTarget>& out) override {
    const std::size_t before = out.size();
    peer_.collect(world, dt, options, out);
    const std::uint64_t placed = peer_.stats().bodies_placed;
    for (std::size_t i = before; i < out.size() && placed > seen_; ++i) {
      const Vec3& x = world.pose(out[i].body).position;
      farthest = std::max(farthest, (out[i].pose.position - x).norm());
    }
    seen_ = placed;
  }

 private:
  Peer& peer_;
  std::uint64_t seen_ = 0;
};

TEST_CASE("resync: an assembly that cannot get through is put there whole, by the higher id",
          "[consensus]") {
  const int profile = GENERATE(1, 3);
  Crowd crowd(network_profile(profile));
  crowd.build = [](Member& member) {
    build_rod(member, member.transport.self() == 1 ? 0.26 : -0.26);
  };
  crowd.add(1, {.authority_ramp = 0.0});
  crowd.add(2, {.authority_ramp = 0.0});
  double stretched = 0.0;
  crowd.after = [&](Member& member) {
    stretched = std::max(stretched, std::abs((member.x(0) - member.x(1)).norm() - 0.3));
  };
  TargetsOfPlaced targets(*crowd[1].peer);
  crowd[1].world->set_target_source(&targets);
  crowd.run(5.0);
  crowd[1].world->set_target_source(nullptr);
  CHECK(targets.farthest < 0.01);  // not drawn back
  INFO("profile " << profile << ", rod stretched by " << 1e3 * stretched << " mm");
  CHECK(spread(crowd, 0) < 1e-3);
  CHECK(spread(crowd, 1) < 1e-3);
  CHECK(crowd[0].peer->stats().bodies_placed == 0);
  CHECK(crowd[1].peer->stats().bodies_placed >= 2);
  CHECK(crowd[0].x(0).x() > 0.25);
  // Never with one ball on either side of the post.
  CHECK(stretched < 0.1);
}

TEST_CASE("resync: a held body is not taken over", "[consensus]") {
  Crowd crowd(network_profile(1));
  crowd.build = [](Member& member) {
    build_rod(member, member.transport.self() == 1 ? 0.26 : -0.26);
  };
  const PeerOptions options{.initiative = false, .authority_ramp = 0.0};  // nobody leads
  Member& leader = crowd.add(1, options);
  Member& follower = crowd.add(2, options);
  const GrabId hand = leader.peer->grab(
      {.body = leader.bodies[0].id, .anchor_w = leader.x(0), .stiffness = 1e-3, .damping = 1e-3});
  crowd.run(3.0);
  CHECK(follower.peer->stats().bodies_placed == 0);
  CHECK(spread(crowd, 0) > 0.2);
  leader.peer->release(hand);
  crowd.run(5.0);
  CHECK(spread(crowd, 0) < 1e-3);
}

TEST_CASE("resync: the minority gives way, whichever its ids", "[consensus]") {
  const PeerId odd = GENERATE(PeerId{1}, PeerId{3});
  Crowd crowd(network_profile(3));
  crowd.build = [odd](Member& member) {
    build_rod(member, member.transport.self() == odd ? 0.26 : -0.26);
  };
  for (PeerId id = 1; id <= 3; ++id) crowd.add(id, {.authority_ramp = 0.0});
  crowd.run(6.0);
  INFO("alone: " << odd);
  CHECK(spread(crowd, 0) < 2e-3);
  CHECK(spread(crowd, 1) < 2e-3);
  for (const auto& member : crowd.members) {
    CHECK(member->x(0).x() < -0.25);
    CHECK((member->peer->stats().bodies_placed > 0) == (member->transport.self() == odd));
  }
}

}  // namespace
}  // namespace tandem::consensus::resync_test
