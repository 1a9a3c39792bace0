// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/metrics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/math.h"

namespace tandem::demos {

namespace {

double percentile(std::vector<double>& values, double p) {
  const double rank = std::ceil(p * static_cast<double>(values.size()));
  const auto index = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

const PeerRecord* find_peer(std::span<const PeerRecord> peers, consensus::PeerId id) {
  for (const PeerRecord& peer : peers) {
    if (peer.id == id) return &peer;
  }
  return nullptr;
}

/// The instances of one body at one time, one for each peer that is there.
DivergenceSample compare(std::span<const TrackSample> instances) {
  DivergenceSample sample;
  int users = 0;
  double speed = 0.0;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const TrackSample& a = instances[i];
    users += a.users;
    speed = std::max(speed, a.speed);
    for (const TrackSample& b : instances.subspan(i + 1)) {
      sample.distance = std::max(sample.distance, (a.position - b.position).norm());
      sample.angle =
          std::max(sample.angle, pbd::rotation_between(a.orientation, b.orientation).norm());
    }
  }
  if (users >= 2) {
    sample.motion = MotionClass::Contested;
  } else if (users == 1 || speed > kMovingSpeed) {
    sample.motion = MotionClass::Moving;
  }
  return sample;
}

Distribution distances(const std::vector<DivergenceSample>& samples, const MotionClass* only) {
  std::vector<double> values;
  for (const DivergenceSample& sample : samples) {
    if (only == nullptr || sample.motion == *only) values.push_back(sample.distance);
  }
  return distribution(values);
}

Distribution degrees(const std::vector<DivergenceSample>& samples) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const DivergenceSample& sample : samples) {
    values.push_back(sample.angle * 180.0 / std::numbers::pi);
  }
  return distribution(values);
}

/// All numbers of one kind, over all peers, in the unit that `scale` makes.
template <class Member>
Distribution gathered(std::span<const PeerRecord> peers, Member member, double scale) {
  std::vector<double> values;
  for (const PeerRecord& peer : peers) {
    for (const double value : peer.*member) values.push_back(scale * value);
  }
  return distribution(values);
}

void add_totals(std::span<const PeerRecord> peers, Metrics& m) {
  double parse = 0.0, process = 0.0, aggregate = 0.0, rate = 0.0;
  std::uint64_t updates = 0, bodies = 0, local = 0;
  std::vector<std::byte> hashes;
  pbd::ByteWriter out(hashes);
  for (const PeerRecord& peer : peers) {
    if (!peer.local) continue;
    ++local;
    parse += peer.parse_s;
    process += peer.process_s;
    aggregate += peer.aggregate_s;
    updates += peer.updates_received;
    bodies += peer.bodies_aggregated;
    if (peer.seconds > 0.0) rate += static_cast<double>(peer.bytes_sent) / peer.seconds;
    m.energy.displacement += peer.energy.displacement;
    m.energy.velocity_agreement += peer.energy.velocity_agreement;
    m.energy.potential += peer.energy.potential;
    m.energy.leak += peer.energy.leak;
    out.u64(peer.hash);
  }
  if (updates > 0) {
    m.parse_us = 1e6 * parse / static_cast<double>(updates);
    m.process_us = 1e6 * process / static_cast<double>(updates);
  }
  if (bodies > 0) m.aggregate_us = 1e6 * aggregate / static_cast<double>(bodies);
  if (local > 0) m.bytes_per_second = rate / static_cast<double>(local);
  m.hash = pbd::hash_bytes(hashes);
}

}  // namespace

Distribution distribution(std::vector<double>& values) {
  Distribution d;
  d.count = values.size();
  if (values.empty()) return d;
  const double n = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double value : values) sum += value;
  d.mean = sum / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - d.mean) * (value - d.mean);
  d.std = std::sqrt(squares / n);
  d.p50 = percentile(values, 0.50);
  d.p75 = percentile(values, 0.75);
  d.p95 = percentile(values, 0.95);
  d.p99 = percentile(values, 0.99);
  d.max = *std::max_element(values.begin(), values.end());
  return d;
}

std::vector<DivergenceSample> divergence(std::span<const PeerRecord> peers,
                                         const EvaluationOptions& options) {
  std::vector<DivergenceSample> samples;
  if (peers.empty()) return samples;
  consensus::SessionTime start = INT64_MAX;
  for (const PeerRecord& peer : peers) start = std::min(start, peer.first_exchange);
  if (start == INT64_MAX) start = INT64_MIN;

  std::vector<TrackSample> instances;
  for (std::uint32_t body = 0; body < peers.front().tracks.size(); ++body) {
    for (const TrackSample& own : peers.front().tracks[body].samples()) {
      if (own.time < start) continue;
      instances.assign(1, own);
      for (const PeerRecord& other : peers.subspan(1)) {
        const auto instance = other.tracks[body].at(own.time, options.max_gap);
        if (instance) instances.push_back(*instance);
      }
      if (instances.size() < 2) continue;
      DivergenceSample sample = compare(instances);
      sample.time = own.time;
      sample.body = body;
      samples.push_back(sample);
    }
  }
  return samples;
}

std::vector<double> prediction_errors(std::span<const PeerRecord> peers,
                                      const EvaluationOptions& options) {
  std::vector<double> errors;
  for (const PeerRecord& peer : peers) {
    for (const PredictionSample& prediction : peer.predictions) {
      const PeerRecord* sender = find_peer(peers, prediction.from);
      if (sender == nullptr || prediction.body >= sender->tracks.size()) continue;
      const auto truth = sender->tracks[prediction.body].at(prediction.time, options.max_gap);
      if (truth) errors.push_back((prediction.position - truth->position).norm());
    }
  }
  return errors;
}

Metrics evaluate(std::span<const PeerRecord> peers, const EvaluationOptions& options) {
  Metrics m;
  m.samples = divergence(peers, options);
  m.divergence_m = distances(m.samples, nullptr);
  for (const auto& [motion, target] : {std::pair{MotionClass::Contested, &m.contested_m},
                                       std::pair{MotionClass::Moving, &m.moving_m},
                                       std::pair{MotionClass::Resting, &m.resting_m}}) {
    *target = distances(m.samples, &motion);
  }
  m.divergence_deg = degrees(m.samples);
  std::vector<double> errors = prediction_errors(peers, options);
  m.prediction_error_m = distribution(errors);
  std::vector<double> ages;
  for (const PeerRecord& peer : peers) {
    for (const PredictionSample& prediction : peer.predictions) {
      ages.push_back(1e3 * prediction.age);
    }
  }
  m.latency_ms = distribution(ages);
  m.step_ms = gathered(peers, &PeerRecord::step_s, 1e3);
  m.penetration_m = gathered(peers, &PeerRecord::penetration_m, 1.0);
  add_totals(peers, m);
  return m;
}

}  // namespace tandem::demos
