// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Rollback of the benchmarks behaves as published: what is confirmed is the same at all peers, bit
// for bit, whatever the network does.
#include <cmath>
#include <deque>
#include <numbers>

#include "measures/metrics.h"
#include "rollback/session.h"
#include "rollback/view.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"

namespace tandem::rollback_bench::rollback_test {
namespace {

using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

demos::DemoOptions demo(int peers, int profile, double loss) {
  demos::DemoOptions options;
  options.peers = peers;
  options.profile = profile;
  options.loss = loss;
  options.seconds = 5.0;
  return options;
}

Run run(const std::string& scene, const demos::DemoOptions& options, const RollbackOptions& how) {
  const auto scenario = make_scenario(scene, options.peers);
  return run_rollback(*scenario, options, how);
}

TEST_CASE("rollback: confirmed frames are the same bits at all peers", "[rollback]") {
  const auto [scene, peers] = GENERATE(table<std::string, int>(
      {{"cubes", 2}, {"room", 2}, {"piano", 2}, {"tennis", 2}, {"table", 4}}));
  const auto [delay, extrapolation, profile, loss] = GENERATE(table<int, int, int, double>(
      {{0, 0, 5, 0.0}, {0, 12, 4, 0.3}, {3, 12, 3, 0.1}, {20, 0, 5, 0.0}}));
  CAPTURE(scene, delay, extrapolation, profile, loss);
  const Run result = run(scene, demo(peers, profile, loss),
                         {.input_delay = delay, .extrapolation = extrapolation});
  CHECK(result.first_desync == -1);
  // All but what is on its way at the end.
  CHECK(result.confirmed > static_cast<std::size_t>(peers) * 240);
  // Inputs that are known in time are never predicted.
  if (delay == 20) CHECK(result.steps_per_frame == 1.0);
  if (delay == 20) CHECK(demos::divergence(result.peers).back().distance == 0.0);
}

TEST_CASE("rollback: a latecomer has the same bits", "[rollback]") {
  const Run result =
      run("table", demo(3, 4, 0.1), {.input_delay = 2, .extrapolation = 12, .join = 120});
  CHECK(result.first_desync == -1);
  CHECK(result.snapshot_bytes > 0);
  CHECK(result.confirmed > 2 * 270 + 150);
}

TEST_CASE("rollback: an engine that differs is found out", "[rollback]") {
  CHECK(run("cubes", demo(2, 3, 0.0), {.other_substeps = 6}).first_desync >= 0);
}

TEST_CASE("rollback: no peer goes on without a member's inputs", "[rollback]") {
  demos::DemoOptions options = demo(3, 3, 0.0);
  options.network = "wifi";
  options.seconds = 10.0;
  const Run result = run("table", options, {});
  CHECK(result.stalled > 0);
  CHECK(result.first_desync == -1);
}

/// Loses all states while it is told to.
class LossyTransport final : public consensus::Transport {
 public:
  explicit LossyTransport(consensus::Transport& inner) : inner_(inner) {}

  bool loses = false;

  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override {
    return loses || inner_.post(to, bytes, delivery);
  }
  void drain(std::vector<consensus::Packet>& out) override { inner_.drain(out); }
  void drop(consensus::PeerId peer, const std::string& reason) override {
    inner_.drop(peer, reason);
  }
  std::vector<consensus::PeerStatus> peers() const override { return inner_.peers(); }

 private:
  consensus::Transport& inner_;
};

/// Peers at the table over a network that delivers before the next frame; the last one may go
/// unheard.
struct Company {
  Company(int peers, const RollbackOptions& options)
      : demo(rollback_test::demo(peers, 0, 0.0)),
        scenario(make_scenario("table", peers)),
        network(demo.link_options(), 1, frame_time(0)) {
    for (int i = 1; i <= peers; ++i) lines.emplace_back(network.transport(i));
    for (int i = 0; i < peers; ++i) members.emplace_back(*scenario, demo, options, i, lines[i]);
  }
  /// @param unheard  the last one is
  void run(int frames, bool unheard) {
    lines.back().loses = unheard;
    for (int i = 0; i < frames; ++i, ++frame) {
      network.advance_to(frame_time(frame));
      for (RollbackPeer& member : members) member.tick(frame);
    }
  }
  std::uint64_t stalled(std::size_t member) const { return members[member].stats().stalled; }
  /// Whether all know all frames but the last few, and have the same bits there.
  bool agree() const {
    for (std::size_t i = 0; i + 3 < static_cast<std::size_t>(frame); ++i) {
      const std::uint64_t hash = members.front().hashes()[i];
      for (const RollbackPeer& member : members) {
        if (i > 0 && (hash == 0 || member.hashes()[i] != hash)) return false;
      }
    }
    return true;
  }

  demos::DemoOptions demo;
  std::unique_ptr<demos::Scenario> scenario;
  consensus::VirtualNetwork network;
  std::deque<LossyTransport> lines;
  std::deque<RollbackPeer> members;
  std::int64_t frame = 0;
};

TEST_CASE("rollback: a silent peer stalls the others after the prediction window", "[rollback]") {
  const int window = GENERATE(6, 20);
  CAPTURE(window);
  Company company(3, {.prediction_window = window});
  company.run(90, false);
  for (std::size_t i = 0; i < 3; ++i) CHECK(company.stalled(i) == 0);
  company.run(window - 2, true);
  CHECK(company.stalled(0) == 0);
  company.run(40, true);
  // The last one hears them.
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(company.stalled(i) >= 36);
    CHECK(company.stalled(i) <= 40);
  }
  const std::uint64_t before = company.stalled(0);
  company.run(60, false);
  CHECK(company.stalled(0) <= before + 2);
  CHECK(company.agree());
}

TEST_CASE("rollback: with n frames in each packet n - 1 losses in a row stall nobody",
          "[rollback]") {
  // With more, what is overdue would have come once more already.
  const int redundancy = GENERATE(2, 3, 4);
  CAPTURE(redundancy);
  const RollbackOptions options{.redundancy = redundancy, .prediction_window = redundancy + 1};
  for (const int more : {0, 2}) {
    CAPTURE(more);
    Company company(2, options);
    company.run(90, false);
    company.run(redundancy - 1 + more, true);
    company.run(60, false);
    CHECK((company.stalled(0) == 0) == (more == 0));
    CHECK(company.agree());
  }
  // With less redundancy there is a gap, until it is known that something is missing.
  Company company(2, {.redundancy = 1, .prediction_window = redundancy + 1});
  company.run(90, false);
  company.run(redundancy - 1, true);
  company.run(60, false);
  CHECK(company.stalled(0) > 0);
}

TEST_CASE("rollback: the picture approaches the world and never leaves it", "[rollback]") {
  constexpr double kSmoothing = 0.1;  // s
  const auto scenario = make_scenario("cubes", 2);
  demos::Scene world = scenario->build({});
  View view(*scenario, demo(2, 3, 0.0), 0, kSmoothing);
  const pbd::Pose old = world.pose(0);
  view.before_correction(world);
  pbd::Pose now = old;
  now.position += pbd::Vec3(0.03, -0.04, 0.1);
  now.orientation = pbd::Quat(Eigen::AngleAxisd(0.5, pbd::Vec3::UnitX())) * old.orientation;
  world.world->set_pose(world.bodies[0].body, now);
  view.after_correction(world);
  view.keep(world, frame_time(1));
  const std::vector<demos::TrackSample>& seen = view.record().tracks[0].samples();
  CHECK((seen.back().position - old.position).norm() < 1e-12);
  CHECK(seen.back().orientation.angularDistance(old.orientation) < 1e-6);
  const double way = (now.position - old.position).norm();
  const double turn = now.orientation.angularDistance(old.orientation);
  double apart = way;
  double turned = turn;
  for (int frame = 1; frame <= 30; ++frame) {
    view.smooth();
    view.keep(world, frame_time(frame + 1));
    const double distance = (seen.back().position - now.position).norm();
    const double angle = seen.back().orientation.angularDistance(now.orientation);
    CAPTURE(frame);
    CHECK(distance < apart);
    CHECK(angle < turned);
    // A part of 1 / e is left after the time, a 150th after five times.
    if (frame == 6) CHECK_THAT(distance, WithinRel(way / std::numbers::e, 1e-6));
    if (frame == 6) CHECK_THAT(angle, WithinRel(turn / std::numbers::e, 1e-3));
    apart = distance;
    turned = angle;
  }
  CHECK(apart < way / 140.0);
  CHECK(turned < turn / 140.0);
}

TEST_CASE("rollback: a late input as predicted sets nothing back", "[rollback]") {
  // Nobody does anything in the first second.
  Company company(2, {});
  company.run(20, false);
  company.run(20, true);
  company.run(10, false);
  CHECK(company.members[0].stats().rollbacks == 0);
  company.run(120, false);
  CHECK(company.members[0].stats().rollbacks > 0);
}

TEST_CASE("rollback: hands that stand are predicted, those that move are carried on",
          "[rollback]") {
  const auto scenario = make_scenario("cubes", 2);
  Replica replica(*scenario, {});
  const Inputs grab = rounded({{.kind = demos::Input::Kind::Grab,
                                .object = 3,
                                .body = 1,
                                .values = {0, 0, 0, 0.1, 0.2, 0.3, 500, 20, 1e3}}});
  replica.apply(0, 0, grab);
  replica.step(0);
  const auto move = [](double x) {
    return rounded({{.kind = demos::Input::Kind::Move, .object = 3, .values = {x, 0.2, 0.3}}});
  };
  for (const bool go_on : {false, true}) CHECK(same(replica.predict(0, 1, go_on), move(0.1)));
  CHECK(replica.predict(1, 1, true).empty());
  double x = 0.1;
  for (int frame = 1; frame <= 30; ++frame) {
    x += 0.01;
    replica.apply(0, frame, move(x));
    replica.step(frame);
  }
  CHECK(same(replica.predict(0, 31, false), move(x)));
  const Inputs further = replica.predict(0, 31, true);
  REQUIRE(further.size() == 1);
  CHECK_THAT(further[0].values[0], WithinAbs(x + 0.01, 1e-5));
}

TEST_CASE("rollback: a signal's code is no body", "[rollback]") {
  const auto scenario = make_scenario("cubes", 2);
  Replica replica(*scenario, {});
  const Inputs inputs =
      rounded({{.kind = demos::Input::Kind::Signal, .object = 60'000, .values = {10.0}}});
  CHECK(inputs[0].object == 60'000);
  CHECK(inputs[0].body == 0);
  CHECK_NOTHROW(replica.apply(0, 0, inputs));
  CHECK_NOTHROW(replica.step(0));
}

}  // namespace
}  // namespace tandem::rollback_bench::rollback_test
