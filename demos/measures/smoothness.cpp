// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/smoothness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace tandem::demos {

namespace {

using pbd::Vec3;

bool moves(const TrackSample& sample) { return sample.users > 0 || sample.speed > kMovingSpeed; }

/// One pass of the high-pass over `values`, in place.
void filter(std::vector<double>& values, double rate, double cutoff) {
  // Bilinear transform of s^2 / (s^2 + sqrt(2) s + 1), prewarped.
  const double k = std::tan(std::numbers::pi * cutoff / rate);
  const double norm = 1.0 / (1.0 + std::numbers::sqrt2 * k + k * k);
  const double a1 = 2.0 * (k * k - 1.0) * norm;
  const double a2 = (1.0 - std::numbers::sqrt2 * k + k * k) * norm;
  // Initial state as if the first value had always been there: its response is 0.
  double x1 = values.empty() ? 0.0 : values.front();
  double x2 = x1, y1 = 0.0, y2 = 0.0;
  for (double& value : values) {
    const double y = norm * (value - 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
    x2 = x1;
    x1 = value;
    y2 = y1;
    y1 = y;
    value = y;
  }
}

/// Lengths of the high-passed positions.
std::vector<double> fast_part(std::span<const Vec3> way, double rate) {
  std::vector<double> result(way.size(), 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(way.size());
    for (const Vec3& p : way) values.push_back(p[axis]);
    values = high_pass(values, rate, Smoothness::kCutoff);
    for (std::size_t i = 0; i < way.size(); ++i) result[i] += values[i] * values[i];
  }
  for (double& value : result) value = std::sqrt(value);
  return result;
}

double rms(const std::vector<double>& values) {
  if (values.empty()) return Distribution::kNone;
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

struct Gathered {
  std::vector<double> acceleration, jerk, fast, arc, correction, speed, free_speed;
  double pops = 0.0, minutes = 0.0;
};

void add_arcs(const std::vector<TrackSample>& samples, double rate, std::vector<double>& out) {
  constexpr double kShortest = 0.5;   // s
  constexpr std::size_t kMax = 2000;  // stretches, over all bodies
  std::vector<double> speed;
  for (std::size_t i = 0; i <= samples.size(); ++i) {
    if (i < samples.size() && samples[i].speed > kMovingSpeed) {
      speed.push_back(samples[i].speed);
      continue;
    }
    if (static_cast<double>(speed.size()) >= kShortest * rate && out.size() < kMax) {
      out.push_back(spectral_arc_length(speed, rate));
    }
    speed.clear();
  }
}

void add_track(const std::vector<TrackSample>& samples, double rate, Gathered& out) {
  std::vector<Vec3> way;
  way.reserve(samples.size());
  for (const TrackSample& s : samples) way.push_back(s.position);
  const std::vector<double> fast = fast_part(way, rate);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    out.speed.push_back(samples[i].speed);
    if (!moves(samples[i])) continue;
    out.fast.push_back(fast[i]);
    out.correction.push_back(samples[i].correction);
    if (samples[i].correction > Smoothness::kPop) out.pops += 1.0;
    if (!samples[i].contact && samples[i].users == 0) out.free_speed.push_back(samples[i].speed);
    if (i < 2) continue;
    const Vec3 acceleration = (way[i] - 2.0 * way[i - 1] + way[i - 2]) * rate * rate;
    out.acceleration.push_back(acceleration.norm());
    if (i < 3) continue;
    const Vec3 before = (way[i - 1] - 2.0 * way[i - 2] + way[i - 3]) * rate * rate;
    out.jerk.push_back((acceleration - before).norm() * rate);
  }
  add_arcs(samples, rate, out.arc);
}

}  // namespace

std::vector<double> high_pass(std::span<const double> values, double rate, double cutoff) {
  std::vector<double> result(values.begin(), values.end());
  filter(result, rate, cutoff);
  std::reverse(result.begin(), result.end());
  filter(result, rate, cutoff);
  std::reverse(result.begin(), result.end());
  return result;
}

double spectral_arc_length(std::span<const double> speed, double rate) {
  constexpr double kHighest = 10.0;    // Hz
  constexpr double kThreshold = 0.05;  // fraction of the spectrum's value at 0
  constexpr int kBins = 200;           // up to kHighest
  std::array<double, kBins + 1> amplitude{};
  for (int bin = 0; bin <= kBins; ++bin) {
    const double angle = 2.0 * std::numbers::pi * kHighest * bin / (kBins * rate);
    const std::complex<double> turn = std::polar(1.0, -angle);
    std::complex<double> sum = 0.0;
    std::complex<double> at = 1.0;
    for (const double value : speed) {
      sum += value * at;
      at *= turn;
    }
    amplitude[static_cast<std::size_t>(bin)] = std::abs(sum);
  }
  if (!(amplitude[0] > 0.0)) return Distribution::kNone;
  int last = kBins;
  while (last > 1 && amplitude[static_cast<std::size_t>(last)] < kThreshold * amplitude[0]) --last;
  double length = 0.0;
  for (int bin = 1; bin <= last; ++bin) {
    const auto i = static_cast<std::size_t>(bin);
    length += std::hypot(1.0 / last, (amplitude[i] - amplitude[i - 1]) / amplitude[0]);
  }
  return -length;
}

Smoothness smoothness(std::span<const PeerRecord> peers) {
  Gathered all;
  for (const PeerRecord& peer : peers) {
    if (!peer.local || peer.step_hz <= 0.0) continue;
    all.minutes += peer.seconds / 60.0;
    for (std::size_t body = 0; body < peer.tracks.size(); ++body) {
      if (!peer.owned(body)) add_track(peer.tracks[body].samples(), peer.step_hz, all);
    }
  }
  Smoothness result;
  result.jerk_rms = rms(all.jerk);
  result.speed_rms = rms(all.speed);
  result.high_pass_rms_m = rms(all.fast);
  result.acceleration = distribution(all.acceleration);
  result.arc_length = distribution(all.arc);
  result.correction_m = distribution(all.correction);
  result.free_speed = distribution(all.free_speed);
  if (all.minutes > 0.0) result.pops_per_minute = all.pops / all.minutes;
  return result;
}

Distribution high_pass_residual(std::span<const PeerRecord> peers, const PeerRecord& reference) {
  std::vector<double> values;
  for (const PeerRecord& peer : peers) {
    if (!peer.local || peer.step_hz <= 0.0) continue;
    const std::size_t bodies = std::min(peer.tracks.size(), reference.tracks.size());
    for (std::size_t body = 0; body < bodies; ++body) {
      if (peer.owned(body)) continue;
      std::vector<Vec3> apart;
      std::vector<bool> moving;
      for (const TrackSample& own : peer.tracks[body].samples()) {
        const auto there = reference.tracks[body].at(own.time);
        if (!there) continue;
        apart.push_back(own.position - there->position);
        moving.push_back(moves(own));
      }
      const std::vector<double> fast = fast_part(apart, peer.step_hz);
      for (std::size_t i = 0; i < fast.size(); ++i) {
        if (moving[i]) values.push_back(fast[i]);
      }
    }
  }
  return distribution(values);
}

}  // namespace tandem::demos
