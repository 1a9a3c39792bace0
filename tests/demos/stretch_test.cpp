// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/stretch.h"

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "measures/report.h"
#include "runner/virtual_runner.h"
#include "runs.h"
#include "support/catch.h"

namespace tandem::demos::stretch_test {
namespace {

using pbd::Vec3;

constexpr double kRate = 60.0;      // Hz
constexpr double kMass = 0.5;       // kg
constexpr double kStiffness = 250;  // N/m
constexpr double kGravity = 9.81;   // m/s^2

/// A user's action: one spring to the middle of the body for a while.
struct Hold {
  double from = 0.0;             ///< s
  double to = 1e9;               ///< s
  Vec3 velocity = Vec3::Zero();  ///< m/s, of the hand, which is at the body's start at 0 s
};

class Holder final : public User {
 public:
  Holder(Controls& controls, const Hold& hold) : controls_(controls), hold_(hold) {}
  void update(consensus::SessionTime /*now*/) override {
    const double time = controls_.time();
    const Vec3 hand = controls_.scene().bodies[0].start + time * hold_.velocity;
    if (spring_ && time >= hold_.to) {
      controls_.release(*spring_);
      spring_.reset();
    } else if (spring_) {
      controls_.move(*spring_, hand);
    } else if (time >= hold_.from && time < hold_.to) {
      consensus::GrabDef def;
      def.anchor_w = hand;
      def.stiffness = kStiffness;
      def.damping = 15.0;
      def.max_force = 1e3;
      spring_ = controls_.grab(0, def);
    }
  }

 private:
  Controls& controls_;
  Hold hold_;
  std::optional<std::uint32_t> spring_;
};

/// A body in the air, and users who hold it as they are told.
class HeldBody final : public Scenario {
 public:
  explicit HeldBody(std::vector<Hold> holds, double damping = 0.0)
      : Scenario("held body", holds.size()), holds_(std::move(holds)), damping_(damping) {}
  Scene build(const SceneOptions& options) const override {
    BodySpec body;
    body.name = "body";
    body.parts.push_back({collision::Sphere{0.05}, {}});
    body.mass = kMass;
    body.pose.position = Vec3(0.0, 0.0, 5.0);
    body.linear_damping = damping_;
    SceneBuilder builder;
    builder.add(body);
    return builder.build(options, 0.5);
  }
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& /*options*/) const override {
    return std::make_unique<Holder>(controls, holds_[user]);
  }

 private:
  std::vector<Hold> holds_;
  double damping_;  ///< 1/s
};

RunResult run(const HeldBody& scenario, int peers, double seconds, int profile = 1) {
  DemoOptions options = quiet(profile, seconds);
  options.peers = peers;
  return run_virtual(scenario, options);
}

consensus::SessionTime step_time(int step) { return std::llround(1e9 * step / kRate); }

/// A peer whose user (or users) holds the only body in the steps [from, to) of 60.
PeerRecord peer(consensus::PeerId id, int from, int to, int users = 1, int springs = 1) {
  PeerRecord record;
  record.id = id;
  record.step_hz = kRate;
  record.tracks.resize(1);
  for (int i = 0; i <= 60; ++i) {
    TrackSample sample;
    sample.time = step_time(i);
    sample.users = i >= from && i < to ? users : 0;
    record.tracks[0].push(sample);
    for (int k = 0; k < springs && sample.users > 0; ++k) {
      record.stretches.push_back({sample.time, 0, users, 0.001 * static_cast<double>(id)});
    }
  }
  return record;
}

TEST_CASE("stretch: a body that hangs from one hand stretches its spring by m g / k",
          "[demos][analytic]") {
  const RunResult result = run(HeldBody({Hold{}}), 1, 6.0);
  const std::vector<StretchSample>& samples = result.peers[0].stretches;
  REQUIRE_FALSE(samples.empty());
  CHECK(samples.front().distance <= 2e-4);  // the hand closes where the body is, but for noise
  CHECK(samples.back().distance == Approx(kMass * kGravity / kStiffness).epsilon(1e-6));
  const Stretch s = stretch(result.peers);
  CHECK(s.one_m.count == samples.size());
  CHECK(s.several_m.count == 0);
  CHECK(s.one_m.p50 == Approx(kMass * kGravity / kStiffness).epsilon(1e-3));
}

TEST_CASE("stretch: two hands share the weight, at one peer or at two", "[demos][analytic]") {
  for (const int peers : {1, 2}) {
    INFO(peers);
    const RunResult result = run(HeldBody({Hold{}, Hold{}}), peers, 6.0);
    for (const PeerRecord& each : result.peers) {
      CHECK(each.stretches.back().users == 3 - peers);
      CHECK(each.stretches.back().distance ==
            Approx(kMass * kGravity / (2.0 * kStiffness)).epsilon(1e-3));
    }
    const Stretch s = stretch(result.peers);
    CHECK(s.several_m.p50 == Approx(kMass * kGravity / (2.0 * kStiffness)).epsilon(1e-2));
    // Holders of a body are known as of a peer's last step, and the second peer joins within the
    // first one's first.
    CHECK(s.one_m.count <= 3);
  }
}

TEST_CASE("stretch: a body dragged through a resisting medium trails by resistance / k",
          "[demos][analytic]") {
  const double speed = 0.8;  // m/s
  const double damping = 3.0;
  const RunResult result =
      run(HeldBody({Hold{.velocity = Vec3(speed, 0.0, 0.0)}}, damping), 1, 6.0);
  // Each of four substeps multiplies the velocity, its gravity included, by this.
  const double h = 1.0 / (4.0 * kRate);
  const double kept = std::exp(-damping * h);
  const double resistance = kMass * speed * (1.0 - kept) / h;  // N; m c v for h to 0
  const double weight = kMass * kGravity * kept;               // N
  CHECK(resistance == Approx(kMass * damping * speed).epsilon(0.01));
  CHECK(result.peers[0].stretches.back().distance ==
        Approx(std::hypot(resistance, weight) / kStiffness).epsilon(1e-4));
}

TEST_CASE("stretch: there is a sample for each step in which a hand holds, and none else",
          "[demos][unit]") {
  const HeldBody scenario({Hold{.from = 0.5, .to = 1.0}});
  const RunResult result = run(scenario, 2, 2.0);
  CHECK(result.peers[0].stretches.size() == 30);
  CHECK(result.peers[0].stretches.front().time >= result.peers[0].epoch + 500'000'000);
  CHECK(result.peers[0].stretches.back().time < result.peers[0].epoch + 1'000'000'000);
  // The other peer also simulates the spring; it is not its own user's.
  CHECK(result.peers[1].stretches.empty());
  const Stretch nobody = stretch(run(HeldBody({Hold{.from = 9.0}}), 2, 1.0).peers);
  CHECK(nobody.one_m.count == 0);
  CHECK(nobody.several_m.count == 0);
  CHECK(std::isnan(nobody.one_m.p50));
}

TEST_CASE("stretch: several are two users of the session, at the same time, on the same body",
          "[demos][unit]") {
  const auto counts = [](const std::vector<PeerRecord>& peers) {
    const Stretch s = stretch(peers);
    return std::pair(s.one_m.count, s.several_m.count);
  };
  using Counts = std::pair<std::size_t, std::size_t>;
  CHECK(counts({peer(1, 10, 30), peer(2, 40, 50)}) == Counts(30, 0));
  CHECK(counts({peer(1, 10, 30), peer(2, 20, 50)}) == Counts(10 + 20, 10 + 10));
  CHECK(counts({peer(1, 10, 30), peer(2, 0, 0), peer(3, 10, 30)}) == Counts(0, 40));
  // Two at one peer are several. One who holds it by three springs is not: three samples each step.
  CHECK(counts({peer(1, 10, 30, 2, 2), peer(2, 0, 0)}) == Counts(0, 40));
  CHECK(counts({peer(1, 10, 30, 1, 3), peer(2, 0, 0)}) == Counts(60, 0));
  // Another body is another matter.
  PeerRecord other = peer(2, 10, 30);
  other.tracks.insert(other.tracks.begin(), Track());
  for (StretchSample& sample : other.stretches) sample.body = 1;
  PeerRecord first = peer(1, 10, 30);
  first.tracks.resize(2);
  CHECK(counts({first, other}) == Counts(40, 0));
  // A peer in another process is known by its track alone; one that is gone holds nothing.
  PeerRecord remote = peer(2, 10, 30);
  remote.local = false;
  remote.stretches.clear();
  CHECK(counts({peer(1, 10, 30), remote}) == Counts(0, 20));
  PeerRecord gone = remote;
  gone.tracks[0] = Track();
  for (const TrackSample& sample : remote.tracks[0].samples()) {
    if (sample.time <= step_time(19)) gone.tracks[0].push(sample);
  }
  CHECK(counts({peer(1, 10, 30), gone}) == Counts(10, 10));
  CHECK(counts({}) == Counts(0, 0));
}

/// One peer, whose user held a body with these stretches (m).
RunResult with_stretches(const std::vector<double>& values) {
  RunResult result;
  result.seconds = result.wall_s = 1.0;
  PeerRecord& record = result.peers.emplace_back();
  record.id = 1;
  record.step_hz = kRate;
  record.tracks.resize(1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    record.stretches.push_back({step_time(static_cast<int>(i)), 0, 1, values[i]});
  }
  return result;
}

/// The run's own field of the report, without the reference's of the same name.
std::string stretch_json(const Report& report) {
  const std::string json = report_json(report);
  const std::size_t begin = json.find("\"stretch_m\": ");
  REQUIRE(begin != std::string::npos);
  return json.substr(begin, json.find("\"blows\"", begin) - begin);
}

TEST_CASE("stretch: percentiles of a known series, and their ratios to those of the reference",
          "[demos][unit]") {
  std::vector<double> millimetres;
  for (int i = 100; i >= 1; --i) millimetres.push_back(1e-3 * i);
  const RunResult result = with_stretches(millimetres);
  const Stretch s = stretch(result.peers);
  CHECK(s.one_m.count == 100);
  CHECK(s.one_m.p50 == 0.050);
  CHECK(s.one_m.p95 == 0.095);
  CHECK(s.one_m.p99 == 0.099);

  const std::string alone = stretch_json(make_report("held", {}, result, {"body"}));
  CHECK_THAT(alone, Catch::Contains("\"p95\": 0.095,"));
  CHECK_THAT(alone, Catch::Contains("\"samples\": 100"));
  CHECK_THAT(alone, Catch::Contains("\"over_reference\": null"));

  for (double& value : millimetres) value *= 0.5;
  const RunResult half = with_stretches(millimetres);
  const Report report = make_report("held", {}, result, {"body"}, &half);
  REQUIRE(report.measures.reference);
  CHECK(report.measures.reference_stretch.one_m.p95 == 0.0475);
  const std::string both = stretch_json(report);
  const std::size_t several = both.find("\"several\"");
  REQUIRE(several != std::string::npos);
  for (const char* ratio : {"\"p50\": 2,", "\"p95\": 2,", "\"p99\": 2\n"}) {
    CHECK_THAT(both.substr(0, several), Catch::Contains(ratio));
  }
  // Nobody holds anything with others: unknown, and no number.
  for (const char* ratio : {"\"p50\": null,", "\"samples\": 0", "\"p99\": null\n"}) {
    CHECK_THAT(both.substr(several), Catch::Contains(ratio));
  }
  const std::string table = report_table(report);
  CHECK_THAT(table, Catch::Contains("stretch, held by one, mm      50.000    75.000    95.000"));
  CHECK_THAT(table, Catch::Contains("over reference               2.000     2.000     2.000"));
}

}  // namespace
}  // namespace tandem::demos::stretch_test
