// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/metrics.h"

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

/// Compares the instances of one body at one time, one per present peer.
DivergenceSample compare(std::span<const TrackSample> instances, bool owned) {
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
  sample.object = object_class(instances, owned);
  return sample;
}

bool is_owned(const PeerRecord& peer, std::size_t body) {
  return body < peer.owners.size() && peer.owners[body] != 0;
}

/// ns, session times at which an owner teleported each body, ascending.
std::vector<std::vector<consensus::SessionTime>> jump_times(std::span<const PeerRecord> peers) {
  std::vector<std::vector<consensus::SessionTime>> jumps(peers.front().tracks.size());
  for (const PeerRecord& peer : peers) {
    for (const Input& input : peer.inputs) {
      if (input.kind == Input::Kind::Jump && input.object < jumps.size()) {
        jumps[input.object].push_back(peer.epoch + input.time);
      }
    }
  }
  for (auto& times : jumps) std::sort(times.begin(), times.end());
  return jumps;
}

bool just_jumped(const std::vector<consensus::SessionTime>& jumps, consensus::SessionTime time,
                 consensus::SessionTime window) {
  const auto after = std::upper_bound(jumps.begin(), jumps.end(), time);
  // The teleport shows one step later.
  return after != jumps.begin() && time - *(after - 1) < window;
}

void add_classes(std::span<const PeerRecord> peers, Metrics& m) {
  std::array<std::vector<double>, kObjectClasses> distance;
  std::vector<double> calm, shared, moving;
  for (const DivergenceSample& sample : m.samples) {
    if (sample.jumped) continue;
    const auto c = static_cast<std::size_t>(sample.object);
    distance[c].push_back(sample.distance);
    calm.push_back(sample.distance);
    if (sample.object == ObjectClass::Owned) continue;
    shared.push_back(sample.distance);
    if (sample.object != ObjectClass::Resting) moving.push_back(sample.distance);
  }
  m.shared_m = distribution(shared);
  m.shared_moving_m = distribution(moving);
  m.calm_m = distribution(calm);
  for (std::size_t c = 0; c < kObjectClasses; ++c) {
    m.object_m[c] = distribution(distance[c]);
  }
  for (const PeerRecord& peer : peers) {
    for (const Input& input : peer.inputs) m.jumps += input.kind == Input::Kind::Jump ? 1 : 0;
  }
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

/// All numbers of one kind, over all peers, times `scale`.
template <class Member>
Distribution gathered(std::span<const PeerRecord> peers, Member member, double scale) {
  std::vector<double> values;
  for (const PeerRecord& peer : peers) {
    for (const double value : peer.*member) values.push_back(scale * value);
  }
  return distribution(values);
}

void add_totals(std::span<const PeerRecord> peers, Metrics& m) {
  double parse = 0.0, process = 0.0, aggregate = 0.0, targets = 0.0, rate = 0.0;
  double cpu = 0.0;
  std::uint64_t updates = 0, bodies = 0, local = 0, steps = 0;
  std::vector<std::byte> hashes;
  pbd::ByteWriter out(hashes);
  for (const PeerRecord& peer : peers) {
    if (!peer.local) continue;
    ++local;
    parse += peer.parse_s;
    process += peer.process_s;
    aggregate += peer.aggregate_s;
    targets += peer.targets_s;
    cpu += peer.cpu_s;
    steps += peer.step_s.size();
    for (std::size_t body = 0; body < peer.tracks.size(); ++body) {
      if (is_owned(peer, static_cast<std::uint32_t>(body))) continue;
      for (const TrackSample& s : peer.tracks[body].samples()) {
        m.peak_speed = std::fmax(m.peak_speed, s.speed);
      }
    }
    updates += peer.updates_received;
    bodies += peer.bodies_aggregated;
    if (peer.seconds > 0.0) rate += static_cast<double>(peer.bytes_sent) / peer.seconds;
    m.energy.displacement += peer.energy.displacement;
    m.energy.velocity_agreement += peer.energy.velocity_agreement;
    m.energy.potential += peer.energy.potential;
    out.u64(peer.hash);
  }
  if (updates > 0) {
    m.parse_us = 1e6 * parse / static_cast<double>(updates);
    m.process_us = 1e6 * process / static_cast<double>(updates);
  }
  if (bodies > 0) {
    m.aggregate_us = 1e6 * aggregate / static_cast<double>(bodies);
    m.targets_us = 1e6 * targets / static_cast<double>(bodies);
  }
  if (steps > 0) m.step_cpu_us = 1e6 * cpu / static_cast<double>(steps);
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
  d.p25 = percentile(values, 0.25);
  d.p50 = percentile(values, 0.50);
  d.p75 = percentile(values, 0.75);
  d.p95 = percentile(values, 0.95);
  d.p99 = percentile(values, 0.99);
  d.max = *std::max_element(values.begin(), values.end());
  const double low = d.p25 - 1.5 * (d.p75 - d.p25);
  const double high = d.p75 + 1.5 * (d.p75 - d.p25);
  d.whisker_low = d.p25;
  d.whisker_high = d.p75;
  std::size_t outside = 0;
  for (const double value : values) {
    if (value < low || value > high) {
      ++outside;
    } else {
      d.whisker_low = std::min(d.whisker_low, value);
      d.whisker_high = std::max(d.whisker_high, value);
    }
  }
  d.outliers = static_cast<double>(outside) / n;
  return d;
}

std::string_view to_string(ObjectClass object) {
  constexpr std::array<std::string_view, kObjectClasses> kNames{"resting", "touching", "free",
                                                                "held", "owned"};
  return kNames[static_cast<std::size_t>(object)];
}

ObjectClass object_class(std::span<const TrackSample> instances, bool owned) {
  if (owned) return ObjectClass::Owned;
  double speed = 0.0;
  bool contact = false;
  for (const TrackSample& instance : instances) {
    if (instance.users > 0) return ObjectClass::Held;
    speed = std::max(speed, instance.speed);
    contact = contact || instance.contact;
  }
  if (speed <= kMovingSpeed) return ObjectClass::Resting;
  return contact ? ObjectClass::Touching : ObjectClass::Free;
}

std::vector<DivergenceSample> divergence(std::span<const PeerRecord> peers,
                                         const EvaluationOptions& options) {
  std::vector<DivergenceSample> samples;
  if (peers.empty()) return samples;
  consensus::SessionTime start = INT64_MAX;
  for (const PeerRecord& peer : peers) start = std::min(start, peer.first_exchange);
  if (start == INT64_MAX) start = INT64_MIN;

  const auto jumps = jump_times(peers);
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
      DivergenceSample sample = compare(instances, is_owned(peers.front(), body));
      sample.time = own.time;
      sample.body = body;
      sample.jumped = just_jumped(jumps[body], own.time, options.jump_window);
      samples.push_back(sample);
    }
  }
  return samples;
}

std::vector<double> prediction_errors(std::span<const PeerRecord> peers,
                                      const EvaluationOptions& options) {
  std::vector<double> errors;
  for (const PeerRecord& peer : peers) {
    for (const PredictionSample& sample : peer.predictions) {
      const PeerRecord* sender = find_peer(peers, sample.from);
      if (sender == nullptr || sample.body >= sender->tracks.size()) continue;
      const auto truth = sender->tracks[sample.body].at(sample.time, options.max_gap);
      if (truth) errors.push_back((sample.position - truth->position).norm());
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
  if (!peers.empty()) add_classes(peers, m);
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
