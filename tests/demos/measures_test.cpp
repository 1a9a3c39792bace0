// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measures/link_probe.h"
#include "support/catch.h"

namespace tandem::demos::measures_test {
namespace {

using pbd::Vec3;

constexpr double kRate = 60.0;
constexpr consensus::SessionTime kMs = 1'000'000;

consensus::SessionTime step_time(int step) { return std::llround(1e9 * step / kRate); }

PeerRecord peer(consensus::PeerId id, std::size_t bodies = 1) {
  PeerRecord record;
  record.id = id;
  record.step_hz = kRate;
  record.seconds = 60.0;
  record.tracks.resize(bodies);
  return record;
}

TrackSample at(consensus::SessionTime time, const Vec3& position,
               const Vec3& velocity = Vec3::Zero(), int users = 0) {
  TrackSample s;
  s.time = time;
  s.position = position;
  s.velocity = velocity;
  s.speed = velocity.norm();
  s.users = users;
  return s;
}

std::vector<double> sine(double frequency, int samples) {
  std::vector<double> values;
  for (int i = 0; i < samples; ++i) {
    values.push_back(1.0 + std::sin(2.0 * std::numbers::pi * frequency * i / kRate));
  }
  return values;
}

/// Amplitude of a sine, from the mean square of the middle half.
double amplitude(const std::vector<double>& values) {
  const auto quarter = static_cast<std::ptrdiff_t>(values.size() / 4);
  double squares = 0.0;
  std::for_each(values.begin() + quarter, values.end() - quarter,
                [&squares](double v) { squares += v * v; });
  return std::sqrt(2.0 * squares / static_cast<double>(values.size() - 2 * values.size() / 4));
}

/// The same for an analogue filter whose frequencies the bilinear transform bends.
double butterworth_gain(double frequency, double cutoff) {
  const double ratio =
      std::tan(std::numbers::pi * cutoff / kRate) / std::tan(std::numbers::pi * frequency / kRate);
  return 1.0 / (1.0 + std::pow(ratio, 4.0));
}

TEST_CASE("smoothness: the high-pass has the gain of a Butterworth filter twice",
          "[demos][analytic]") {
  for (const double frequency : {1.0, 2.5, 5.0, 12.0}) {
    const double gain = amplitude(high_pass(sine(frequency, 1200), kRate, 5.0));
    CHECK(gain == Approx(butterworth_gain(frequency, 5.0)).epsilon(0.02));
  }
  CHECK(butterworth_gain(5.0, 5.0) == 0.5);
  const std::vector<double> still(50, 7.0);
  CHECK(amplitude(high_pass(still, kRate, 5.0)) == 0.0);
  CHECK(high_pass({}, kRate, 5.0).empty());
}

TEST_CASE("smoothness: one minimum-jerk move is smoother than two, and both than with tremor",
          "[demos][analytic]") {
  const auto bell = [](double s) {
    return s < 0.0 || s > 1.0 ? 0.0 : 30.0 * s * s * (1 - s) * (1 - s);
  };
  std::vector<double> one, two, shaky;
  for (int i = 0; i <= 120; ++i) {
    const double t = i / kRate;
    one.push_back(bell(t / 2.0));
    two.push_back(bell(t / 1.1) + bell((t - 0.9) / 1.1));
    shaky.push_back(one.back() * (1.0 + 0.5 * std::sin(2.0 * std::numbers::pi * 6.0 * t)));
  }
  const double first = spectral_arc_length(one, kRate);
  CHECK(first < -1.0);
  CHECK(first > -1.65);  // Balasubramanian et al. 2015 give -1.4 to -1.6 for a single one
  CHECK(spectral_arc_length(two, kRate) < first - 0.1);
  CHECK(spectral_arc_length(shaky, kRate) < first - 0.1);
  // Twice as fast and for twice the samples' rate, it is the same.
  std::vector<double> louder = one;
  for (double& v : louder) v *= 3.0;
  CHECK(spectral_arc_length(louder, kRate) == Approx(first));
  CHECK(std::isnan(spectral_arc_length(std::vector<double>(9, 0.0), kRate)));
}

TEST_CASE("smoothness: a parabola has one acceleration and no jerk; pops are counted",
          "[demos][analytic]") {
  std::vector<PeerRecord> peers{peer(1)};
  for (int i = 0; i < 60; ++i) {
    const double t = i / kRate;
    TrackSample s = at(step_time(i), Vec3(t, 0.0, -0.5 * 9.81 * t * t), Vec3(1.0, 0.0, -9.81 * t));
    if (i == 10 || i == 20) s.correction = 0.006;
    peers[0].tracks[0].push(s);
  }
  const Smoothness s = smoothness(peers);
  CHECK(s.acceleration.count == 58);
  CHECK(s.acceleration.p50 == Approx(9.81));
  CHECK(s.acceleration.max == Approx(9.81));
  CHECK(s.jerk_rms < 1e-8);
  CHECK(s.pops_per_minute == Approx(2.0));
  CHECK(s.correction_m.max == 0.006);
  CHECK(s.free_speed.count == 60);
  // The mean of the squares of i = 0 .. 59 is 59 * 119 / 6.
  const double fall = 9.81 / kRate;
  CHECK(s.speed_rms == Approx(std::sqrt(1.0 + fall * fall * 59.0 * 119.0 / 6.0)));
  // Bodies moved by their owner are not looked at.
  peers[0].owners = {1};
  CHECK(smoothness(peers).acceleration.count == 0);
}

TEST_CASE("smoothness: a residual is the fast part of the difference to the reference",
          "[demos][analytic]") {
  std::vector<PeerRecord> peers{peer(1)};
  PeerRecord reference = peer(1);
  const std::vector<double> fast = sine(12.0, 600);
  for (int i = 0; i < 600; ++i) {
    const double x = i / kRate;
    reference.tracks[0].push(at(step_time(i), Vec3(x, 0, 0), Vec3::UnitX()));
    const double y = 1e-3 * (fast[static_cast<std::size_t>(i)] - 1.0);
    peers[0].tracks[0].push(at(step_time(i), Vec3(x + 0.5, y, 0), Vec3::UnitX()));
  }
  const Distribution d = high_pass_residual(peers, reference);
  CHECK(d.count == 600);
  CHECK(d.p99 == Approx(1e-3 * butterworth_gain(12.0, 5.0)).epsilon(0.05));
  CHECK(high_pass_residual(peers, peers[0]).max == 0.0);
}

TEST_CASE("agreement: pairs that touch at one peer alone are disagreement", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  peers[0].contacts = {{0, {1, 2, 3}}, {100 * kMs, {}}, {200 * kMs, {5}}};
  peers[1].contacts = {{10 * kMs, {2, 3, 4}}, {90 * kMs, {}}, {190 * kMs, {}}};
  const std::vector<double> d = contact_disagreement(peers);
  REQUIRE(d.size() == 3);
  CHECK(d[0] == Approx(0.5));  // 2 of 4
  CHECK(d[1] == 0.0);
  CHECK(d[2] == 1.0);
}

TEST_CASE("agreement: time runs from the last input to the last body apart", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  peers[0].epoch = 1000 * kMs;
  Input release;
  release.kind = Input::Kind::Release;
  release.time = 500 * kMs;
  Input drive = release;
  drive.kind = Input::Kind::Drive;
  drive.time = 5000 * kMs;
  peers[0].inputs = {release, drive};
  std::vector<DivergenceSample> samples(4);
  const double apart[] = {0.02, 0.006, 0.004, 0.004};
  for (std::size_t i = 0; i < 4; ++i) {
    samples[i].time = static_cast<consensus::SessionTime>(1400 + 200 * i) * kMs;
    samples[i].distance = apart[i];
  }
  CHECK(time_to_agree(peers, samples, 5e-3) == Approx(0.1));  // 1.6 s less 1.5 s
  CHECK(time_to_agree(peers, samples, 1.0) == 0.0);
  CHECK(std::isnan(time_to_agree(peers, samples, 1e-3)));
  samples[1].object = ObjectClass::Owned;
  CHECK(time_to_agree(peers, samples, 5e-3) == 0.0);
}

TEST_CASE("agreement: the limit of a body held with constant acceleration is a t^2 / 2",
          "[demos][analytic]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  for (int i = 0; i < 60; ++i) {
    const double t = i / kRate;
    peers[0].tracks[0].push(at(step_time(i), Vec3(1.5 * t * t, 0, 0), Vec3(3.0 * t, 0, 0), 1));
    peers[1].tracks[0].push(at(step_time(i), Vec3(1.5 * t * t, 0.01, 0), Vec3(3.0 * t, 0, 0)));
  }
  // Used at the other peer 83.3 ms after, and seen a step later.
  peers[1].predictions.push_back({.from = 1, .body = 0, .time = 0, .age = 0.1 - 1.0 / kRate});
  peers[1].predictions.push_back({.from = 3, .body = 0, .time = 0, .age = 1.0});
  CHECK(news_age(peers[1], peers[0]) == Approx(0.1));
  const HeldByOne held = held_by_one(peers);
  const Distribution& limit = held.limit_m;
  CHECK(limit.p50 == Approx(0.5 * 3.0 * 0.1 * 0.1));
  CHECK(limit.max == Approx(limit.p50));
  CHECK(held.apart_m.p50 == Approx(0.01));
  const Distribution all = limit_of_all(peers, 0.1);
  CHECK(all.count == 60);
  CHECK(all.max == Approx(limit.p50));
}

TEST_CASE("agreement: bodies that two users hold count neither for the limit nor against it",
          "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1, 2), peer(2, 2)};
  for (int i = 0; i < 60; ++i) {
    const Vec3 fast(3.0 * i / kRate, 0, 0);
    peers[0].tracks[0].push(at(step_time(i), Vec3::Zero(), fast, 1));
    peers[1].tracks[0].push(at(step_time(i), Vec3::Zero(), fast, 0));
    for (PeerRecord& p : peers) p.tracks[1].push(at(step_time(i), Vec3::Zero(), Vec3::Zero(), 1));
  }
  const HeldByOne held = held_by_one(peers);
  CHECK(held.limit_m.count == held.apart_m.count);
  CHECK(held.limit_m.count == 59);  // of the first body, all but its first, before which is none
  // a t^2 / 2 with t one step: no news tell more than their step. No zeros of the second body.
  CHECK(held.limit_m.p50 == Approx(0.5 * 3.0 / (kRate * kRate)));
}

TEST_CASE("agreement: a blow is a jump of velocity near a body that its owner moves",
          "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1, 2), peer(2, 2)};
  for (PeerRecord& p : peers) p.owners = {0, 1};
  for (PeerRecord& p : peers) {
    for (int i = 0; i < 60; ++i) {
      // Hit at step 30 by the racket at x = 0, and once on a table far away.
      const double vx = i < 30 ? -3.0 : 3.0;
      const double x = std::abs(i - 30) * 3.0 / kRate;
      const double vz = i < 50 ? -2.0 : 2.0;
      p.tracks[0].push(at(step_time(i), Vec3(x, 0, 0), Vec3(vx, 0, vz)));
      p.tracks[1].push(at(step_time(i), Vec3(0, 0, 0.1)));
    }
  }
  const std::vector<Blow> found = blows(peers);
  REQUIRE(found.size() == 1);  // at its owner's peer, not where the racket follows
  CHECK(found[0].time == step_time(30));
  CHECK(found[0].body == 0);

  std::vector<DivergenceSample> samples;
  for (int i = 0; i < 60; ++i) {
    DivergenceSample s;
    s.time = step_time(i);
    s.distance = i < 28 ? 9.0 : i < 45 ? 0.2 : 0.01;
    samples.push_back(s);
  }
  // 0.1 s of delivery and 0.15 s after it: steps 28 to 44, one of them on the border.
  const AfterBlows after = after_blows(peers, samples, 0.1001);
  CHECK(after.blows == 1);
  CHECK(after.before_m.max == Approx(0.2));
  CHECK(after.before_m.count >= 17);
  CHECK(after.after_m.p50 == Approx(0.01));
}

TEST_CASE("metrics: classes by owner, hand, speed and contact", "[demos][unit]") {
  TrackSample a = at(0, Vec3::Zero());
  TrackSample b = a;
  const auto of = [&a, &b](bool owned) {
    const std::vector<TrackSample> both{a, b};
    return object_class(both, owned);
  };
  CHECK(of(false) == ObjectClass::Resting);
  CHECK(of(true) == ObjectClass::Owned);
  b.contact = true;
  CHECK(of(false) == ObjectClass::Resting);
  a.speed = 0.051;
  CHECK(of(false) == ObjectClass::Touching);
  b.contact = false;
  CHECK(of(false) == ObjectClass::Free);
  b.users = 1;
  CHECK(of(false) == ObjectClass::Held);
}

TEST_CASE("metrics: bodies that have just jumped count apart and in the whole", "[demos][unit]") {
  std::vector<PeerRecord> peers{peer(1), peer(2)};
  for (PeerRecord& p : peers) p.owners = {1};
  peers[0].epoch = 100 * kMs;
  Input jump;
  jump.kind = Input::Kind::Jump;
  jump.time = 400 * kMs;
  peers[0].inputs = {jump};
  for (int i = 0; i < 60; ++i) {
    const auto t = step_time(i);
    peers[0].tracks[0].push(at(t, Vec3(t > 500 * kMs ? 2.0 : 0.0, 0, 0)));
    peers[1].tracks[0].push(at(t, Vec3(t > 700 * kMs ? 2.0 : 0.0, 0, 0)));
  }
  const Metrics m = evaluate(peers);
  CHECK(m.jumps == 1);
  CHECK(m.divergence_m.max == Approx(2.0));
  CHECK(m.divergence_m.count == 60);
  CHECK(m.calm_m.max == 0.0);
  CHECK(m.calm_m.count == 42);  // 18 steps in 0.3 s
  CHECK(m.object_m[static_cast<std::size_t>(ObjectClass::Owned)].count == 42);
  CHECK(m.shared_m.count == 0);
}

TEST_CASE("metrics: whiskers end at the last values within 1.5 boxes", "[demos][unit]") {
  std::vector<double> values{1, 2, 3, 4, 5, 6, 7, 8, 13, 100};
  const Distribution d = distribution(values);
  CHECK(d.p25 == 3.0);
  CHECK(d.p75 == 8.0);
  CHECK(d.whisker_low == 1.0);
  CHECK(d.whisker_high == 13.0);  // the limit is 15.5
  CHECK(d.outliers == Approx(0.1));
}

TEST_CASE("link: its own latencies are those of the profile", "[demos][analytic]") {
  std::vector<double> values = link_latencies(consensus::network_profile(5), 60.0, 10.0, 3);
  REQUIRE(values.size() == 600);
  const Distribution d = distribution(values);
  // Uniform in 123.5 +- 5 ms, seen to 0.1 ms; the mean of 600 within 4 standard errors.
  CHECK(d.mean == Approx(123.55).margin(4.0 * 5.0 / std::sqrt(3.0 * 600.0)));
  CHECK(d.max <= 128.6);
  CHECK(*std::min_element(values.begin(), values.end()) >= 118.5);
  CHECK(d.std == Approx(5.0 / std::sqrt(3.0)).epsilon(0.1));
}

TEST_CASE("measures: a histogram counts everything once", "[demos][unit]") {
  const std::vector<std::uint64_t> counts =
      histogram({-1.0, 0.0, 0.5, 1.0, 2.9, 77.0}, 0.0, 1.0, 3);
  CHECK(counts == std::vector<std::uint64_t>{3, 1, 2});
}

}  // namespace
}  // namespace tandem::demos::measures_test
