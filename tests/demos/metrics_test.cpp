// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/metrics.h"

#include <cmath>
#include <numbers>

#include "support/catch.h"
#include "tandem/pbd/math.h"

namespace tandem::demos::metrics_test {
namespace {

using pbd::Vec3;

constexpr consensus::SessionTime kMs = 1'000'000;

TrackSample sample(consensus::SessionTime time, const Vec3& position, double speed = 0.0,
                   int users = 0, const Vec3& rotation = Vec3::Zero()) {
  TrackSample s;
  s.time = time;
  s.position = position;
  s.orientation = pbd::exp_map(rotation);
  s.speed = speed;
  s.users = users;
  return s;
}

PeerRecord peer(consensus::PeerId id, std::size_t bodies = 1) {
  PeerRecord record;
  record.id = id;
  record.tracks.resize(bodies);
  return record;
}

TEST_CASE("metrics: percentiles are nearest-rank and exact", "[demos][unit]") {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Distribution d = distribution(values);
  CHECK(d.count == 100);
  CHECK(d.p50 == 50.0);
  CHECK(d.p75 == 75.0);
  CHECK(d.p95 == 95.0);
  CHECK(d.p99 == 99.0);
  CHECK(d.max == 100.0);
  CHECK(d.mean == Approx(50.5));
  CHECK(d.std == Approx(std::sqrt((100.0 * 100.0 - 1.0) / 12.0)));

  std::vector<double> one{3.0};
  CHECK(distribution(one).p50 == 3.0);
  CHECK(distribution(one).p99 == 3.0);
  std::vector<double> none;
  CHECK(std::isnan(distribution(none).p50));
  CHECK(std::isnan(distribution(none).max));
}

TEST_CASE("track: between samples bodies fall on parabolas and bounce off straight",
          "[demos][analytic]") {
  constexpr double kDt = 1.0 / 60.0;
  const Vec3 g(0.0, 0.0, -9.81);
  const auto time = [](double t) { return std::llround(1e9 * (1.0 + t)); };
  const auto state = [&](double t, const Vec3& x, const Vec3& v) {
    TrackSample s = sample(time(t), x, v.norm());
    s.velocity = v;
    return s;
  };
  Track falls;
  const Vec3 v0(2.0, -1.0, 0.5);
  falls.push(state(0.0, Vec3::Zero(), v0));
  falls.push(state(kDt, kDt * v0 + 0.5 * kDt * kDt * g, v0 + kDt * g));
  // Down at 3 m/s, off the ground at 2 m/s after 0.4 of the step.
  constexpr double kHit = 0.4 * kDt;
  const Vec3 down(1.0, 0.0, -3.0);
  const Vec3 up(1.0, 0.0, 2.0);
  Track bounces;
  bounces.push(state(0.0, Vec3::Zero(), down));
  bounces.push(state(kDt, kHit * down + (kDt - kHit) * up, up));
  for (const double f : {0.1, 0.3, 0.4, 0.5, 0.9}) {
    const double t = f * kDt;
    CHECK((falls.at(time(t))->position - (t * v0 + 0.5 * t * t * g)).norm() < 1e-8);
    const Vec3 there = std::min(t, kHit) * down + std::max(t - kHit, 0.0) * up;
    CHECK((bounces.at(time(t))->position - there).norm() < 1e-8);
  }
}

TEST_CASE("track: steady positions are interpolated on the line, orientations on the arc",
          "[demos][analytic]") {
  Track track;
  const Vec3 quarter(0.0, 0.0, std::numbers::pi / 2.0);
  TrackSample from = sample(100, Vec3(0.0, 0.0, 0.0), 1.0, 1);
  TrackSample to = sample(200, Vec3(1.0, 2.0, 4.0), 3.0, 0, quarter);
  from.velocity = to.velocity = Vec3(1.0, 2.0, 4.0) / 100e-9;
  track.push(from);
  track.push(to);
  const auto middle = track.at(125);
  REQUIRE(middle.has_value());
  CHECK((middle->position - Vec3(0.25, 0.5, 1.0)).norm() < 1e-15);
  CHECK(middle->speed == Approx(1.5));
  CHECK(middle->users == 1);
  CHECK(pbd::log_map(middle->orientation).z() == Approx(std::numbers::pi / 8.0));
  CHECK(track.at(100)->users == 1);
  CHECK(track.at(200)->users == 0);
  CHECK_FALSE(track.at(99).has_value());
  CHECK_FALSE(track.at(201).has_value());
  CHECK(track.at(150, 100).has_value());
  CHECK_FALSE(track.at(150, 99).has_value());
  CHECK(track.at(200, 99).has_value());  // a sample itself is never in a gap
}

TEST_CASE("metrics: two bodies on one line, seen at other times, do not diverge",
          "[demos][analytic]") {
  // x = v t at both peers, at 60 and 72 steps each second with another phase.
  PeerRecord a = peer(1);
  PeerRecord b = peer(2);
  const auto on_line = [](consensus::SessionTime t) {
    return Vec3(2.0 * static_cast<double>(t) * 1e-9, 0.0, 0.0);
  };
  const auto moving = [](consensus::SessionTime t, const Vec3& position) {
    TrackSample s = sample(t, position, 2.0);
    s.velocity = Vec3(2.0, 0.0, 0.0);
    return s;
  };
  for (int i = 0; i < 120; ++i) {
    const consensus::SessionTime t = i * 16'666'667ll;
    a.tracks[0].push(moving(t, on_line(t)));
  }
  for (int i = 0; i < 140; ++i) {
    const consensus::SessionTime t = 5'000'000 + i * 13'888'889ll;
    b.tracks[0].push(moving(t, on_line(t) + Vec3(0.0, 0.003, 0.0)));
  }
  const std::vector<PeerRecord> peers{a, b};
  const std::vector<DivergenceSample> samples = divergence(peers);
  // b covers 5 ms to 1.936 s: a's steps 1 to 116.
  REQUIRE(samples.size() == 116);
  for (const DivergenceSample& s : samples) {
    CHECK(s.distance == Approx(0.003));
    CHECK(s.motion == MotionClass::Moving);
  }
}

TEST_CASE("metrics: the largest pair of three peers counts, in distance and in angle",
          "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2), peer(3)};
  peers[0].tracks[0].push(sample(10, Vec3(0.0, 0.0, 0.0)));
  peers[1].tracks[0].push(sample(10, Vec3(0.003, 0.0, 0.0), 0.0, 0, Vec3(0.2, 0.0, 0.0)));
  peers[2].tracks[0].push(sample(10, Vec3(0.0, 0.004, 0.0), 0.0, 0, Vec3(-0.1, 0.0, 0.0)));
  const std::vector<DivergenceSample> samples = divergence(peers);
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].distance == Approx(0.005));  // between the second and the third
  CHECK(samples[0].angle == Approx(0.3));
}

TEST_CASE("metrics: classes follow hands and the fastest instance", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  struct Case {
    int users_a, users_b;
    double speed_a, speed_b;
    MotionClass expected;
  };
  const std::vector<Case> cases{
      {0, 0, 0.0, 0.0, MotionClass::Resting},   {0, 0, 0.0, 0.05, MotionClass::Resting},
      {0, 0, 0.0, 0.051, MotionClass::Moving},  {0, 0, 0.06, 0.0, MotionClass::Moving},
      {1, 0, 0.0, 0.0, MotionClass::Moving},    {0, 1, 0.0, 0.0, MotionClass::Moving},
      {1, 1, 0.0, 0.0, MotionClass::Contested}, {2, 0, 0.0, 0.0, MotionClass::Contested},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto t = static_cast<consensus::SessionTime>(i);
    peers[0].tracks[0].push(sample(t, Vec3::Zero(), cases[i].speed_a, cases[i].users_a));
    peers[1].tracks[0].push(sample(t, Vec3::Zero(), cases[i].speed_b, cases[i].users_b));
  }
  const std::vector<DivergenceSample> samples = divergence(peers);
  REQUIRE(samples.size() == cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) CHECK(samples[i].motion == cases[i].expected);
}

TEST_CASE("metrics: classes split the whole and nothing is lost", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  for (int i = 0; i < 30; ++i) {
    const int users = i < 10 ? 1 : 0;
    peers[0].tracks[0].push(sample(i, Vec3::Zero(), i < 20 ? 1.0 : 0.0, users));
    peers[1].tracks[0].push(sample(i, Vec3(1e-3 * i, 0.0, 0.0), 0.0, users));
  }
  const Metrics m = evaluate(peers);
  CHECK(m.divergence_m.count == 30);
  CHECK(m.contested_m.count == 10);
  CHECK(m.moving_m.count == 10);
  CHECK(m.resting_m.count == 10);
  CHECK(m.divergence_m.max == Approx(0.029));  // no outlier is removed
  CHECK(m.contested_m.max == Approx(0.009));
  CHECK(m.moving_m.p50 == Approx(0.014));
  CHECK(m.resting_m.p50 == Approx(0.024));
}

TEST_CASE("metrics: divergence counts from the first exchange on", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  for (int i = 0; i < 10; ++i) {
    peers[0].tracks[0].push(sample(i * kMs, Vec3::Zero()));
    peers[1].tracks[0].push(sample(i * kMs, Vec3::Zero()));
  }
  CHECK(divergence(peers).size() == 10);  // no exchange at all: from the start
  peers[0].first_exchange = 7 * kMs;
  peers[1].first_exchange = 4 * kMs;
  const std::vector<DivergenceSample> samples = divergence(peers);
  REQUIRE(samples.size() == 6);
  CHECK(samples.front().time == 4 * kMs);
}

TEST_CASE("metrics: a prediction is measured against the sender's body at that time",
          "[demos][analytic]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  for (int i = 0; i <= 10; ++i) {
    peers[1].tracks[0].push(sample(i * 10 * kMs, Vec3(0.1 * i, 0.0, 0.0)));
  }
  // At 55 ms the sender's body is at 0.55 m.
  peers[0].predictions.push_back({2, 0, 55 * kMs, 0.030, Vec3(0.55, 0.002, 0.0)});
  peers[0].predictions.push_back({2, 0, 200 * kMs, 0.050, Vec3(9.0, 0.0, 0.0)});  // not covered
  peers[0].predictions.push_back({3, 0, 55 * kMs, 0.010, Vec3(9.0, 0.0, 0.0)});   // unknown peer
  const std::vector<double> errors = prediction_errors(peers);
  REQUIRE(errors.size() == 1);
  CHECK(errors[0] == Approx(0.002));
  const Metrics m = evaluate(peers);
  CHECK(m.latency_ms.mean == Approx(30.0));
  CHECK(m.latency_ms.p99 == Approx(50.0));
}

TEST_CASE("metrics: sums are over peers, rates for each", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2), peer(3)};
  peers[2].local = false;
  for (std::size_t i = 0; i < 2; ++i) {
    peers[i].parse_s = 1e-3;
    peers[i].process_s = 2e-3;
    peers[i].aggregate_s = 4e-3;
    peers[i].updates_received = 1000;
    peers[i].bodies_aggregated = 500;
    peers[i].bytes_sent = 10000 * (i + 1);
    peers[i].seconds = 10.0;
    peers[i].step_s = {0.001, 0.003};
  }
  const Metrics m = evaluate(peers);
  CHECK(m.parse_us == Approx(1.0));
  CHECK(m.process_us == Approx(2.0));
  CHECK(m.aggregate_us == Approx(8.0));
  CHECK(m.bytes_per_second == Approx(1500.0));
  CHECK(m.step_ms.mean == Approx(2.0));
}

}  // namespace
}  // namespace tandem::demos::metrics_test
