// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/agreement.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace tandem::demos {

namespace {

using consensus::SessionTime;

double seconds(SessionTime ns) { return 1e-9 * static_cast<double>(ns); }

/// The frame nearest in time; frames are ascending and not empty.
const ContactFrame& nearest(const std::vector<ContactFrame>& frames, SessionTime time) {
  const auto after =
      std::lower_bound(frames.begin(), frames.end(), time,
                       [](const ContactFrame& f, SessionTime t) { return f.time < t; });
  if (after == frames.begin()) return *after;
  if (after == frames.end()) return frames.back();
  return after->time - time < time - (after - 1)->time ? *after : *(after - 1);
}

}  // namespace

std::vector<double> contact_disagreement(std::span<const PeerRecord> peers) {
  std::vector<double> result;
  if (peers.empty() || !peers.front().local) return result;
  for (const PeerRecord& other : peers.subspan(1)) {
    if (!other.local || other.contacts.empty()) continue;
    for (const ContactFrame& a : peers.front().contacts) {
      const ContactFrame& b = nearest(other.contacts, a.time);
      std::vector<std::uint64_t> both;
      std::set_intersection(a.pairs.begin(), a.pairs.end(), b.pairs.begin(), b.pairs.end(),
                            std::back_inserter(both));
      const double either = static_cast<double>(a.pairs.size() + b.pairs.size() - both.size());
      result.push_back(either == 0.0 ? 0.0 : 1.0 - static_cast<double>(both.size()) / either);
    }
  }
  return result;
}

double time_to_agree(std::span<const PeerRecord> peers, std::span<const DivergenceSample> samples,
                     double tolerance) {
  SessionTime input = INT64_MIN;
  SessionTime end = INT64_MIN;
  for (const PeerRecord& peer : peers) {
    for (const Input& i : peer.inputs) {
      const bool own = i.kind == Input::Kind::Drive || i.kind == Input::Kind::Jump;
      if (!own) input = std::max(input, peer.epoch + i.time);
    }
  }
  if (input == INT64_MIN || samples.empty()) return Distribution::kNone;
  SessionTime apart = INT64_MIN;
  for (const DivergenceSample& sample : samples) {
    end = std::max(end, sample.time);
    if (sample.object == ObjectClass::Owned || sample.distance <= tolerance) continue;
    apart = std::max(apart, sample.time);
  }
  if (apart == end || input >= end) return Distribution::kNone;
  return apart > input ? seconds(apart - input) : 0.0;
}

Distribution limit_of_all(std::span<const PeerRecord> peers, double age,
                          const EvaluationOptions& options) {
  std::vector<double> values;
  if (peers.empty()) return distribution(values);
  const auto late = static_cast<SessionTime>(std::llround(1e9 * age));
  for (std::size_t body = 0; body < peers.front().tracks.size(); ++body) {
    for (const TrackSample& sample : peers.front().tracks[body].samples()) {
      double limit = 0.0;
      for (const PeerRecord& peer : peers) {
        const auto now = peer.tracks[body].at(sample.time, options.max_gap);
        const auto before = peer.tracks[body].at(sample.time - late, options.max_gap);
        if (!now || !before) continue;
        const bool own = body < peer.owners.size() && peer.owners[body] == peer.id;
        if (!own && now->users == 0) continue;
        limit = std::max(limit, 0.5 * age * (now->velocity - before->velocity).norm());
      }
      values.push_back(limit);
    }
  }
  return distribution(values);
}

double news_age(const PeerRecord& listener, const PeerRecord& sender) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const PredictionSample& p : listener.predictions) {
    if (p.from != sender.id) continue;
    sum += p.age;
    ++count;
  }
  // A remote listener's use of updates is not observed: the way back takes about as long.
  if (count == 0 && !listener.local && sender.local) return news_age(sender, listener);
  const double step = listener.step_hz > 0.0 ? 1.0 / listener.step_hz : 0.0;
  return step + (count > 0 ? sum / static_cast<double>(count) : 0.0);
}

HeldByOne held_by_one(std::span<const PeerRecord> peers, const EvaluationOptions& options) {
  std::vector<double> distances, limits;
  for (const PeerRecord& peer : peers) {
    std::vector<double> ages;
    for (const PeerRecord& other : peers) ages.push_back(news_age(other, peer));
    for (std::size_t body = 0; body < peer.tracks.size(); ++body) {
      if (peer.owned(body)) continue;
      for (const TrackSample& own : peer.tracks[body].samples()) {
        if (own.users != 1) continue;
        double apart = -1.0;
        double limit = -1.0;
        int users = own.users;
        for (std::size_t k = 0; k < peers.size(); ++k) {
          if (&peers[k] == &peer) continue;
          const auto there = peers[k].tracks[body].at(own.time, options.max_gap);
          if (!there) continue;
          users += there->users;
          apart = std::max(apart, (there->position - own.position).norm());
          const auto late = static_cast<SessionTime>(std::llround(1e9 * ages[k]));
          const auto before = peer.tracks[body].at(own.time - late, options.max_gap);
          if (!before) continue;
          limit = std::max(limit, 0.5 * ages[k] * (own.velocity - before->velocity).norm());
        }
        if (users != 1 || apart < 0.0 || limit < 0.0) continue;
        distances.push_back(apart);
        limits.push_back(limit);
      }
    }
  }
  return {distribution(distances), distribution(limits)};
}

std::vector<Blow> blows(std::span<const PeerRecord> peers) {
  constexpr double kChange = 2.0;  // m/s
  constexpr double kNear = 0.35;   // m
  std::vector<Blow> result;
  for (const PeerRecord& peer : peers) {
    if (!peer.local) continue;
    for (std::uint32_t body = 0; body < peer.tracks.size(); ++body) {
      if (peer.owned(body)) continue;
      const std::vector<TrackSample>& samples = peer.tracks[body].samples();
      for (std::size_t i = 1; i < samples.size(); ++i) {
        if ((samples[i].velocity - samples[i - 1].velocity).norm() < kChange) continue;
        for (std::size_t j = 0; j < peer.tracks.size(); ++j) {
          if (!peer.owned(j) || peer.owners[j] != peer.id) continue;
          const auto racket = peer.tracks[j].at(samples[i].time);
          if (racket && (racket->position - samples[i].position).norm() < kNear) {
            result.push_back({samples[i].time, body});
            break;
          }
        }
      }
    }
  }
  std::sort(result.begin(), result.end(), [](const Blow& a, const Blow& b) {
    return a.body != b.body ? a.body < b.body : a.time < b.time;
  });
  return result;
}

AfterBlows after_blows(std::span<const PeerRecord> peers, std::span<const DivergenceSample> samples,
                       double delivery) {
  std::map<std::uint32_t, std::vector<SessionTime>> times;
  AfterBlows result;
  for (const Blow& blow : blows(peers)) {
    times[blow.body].push_back(blow.time);
    ++result.blows;
  }
  std::vector<double> before, after;
  const auto ahead = static_cast<SessionTime>(1e9 * AfterBlows::kAhead);
  for (const DivergenceSample& sample : samples) {
    const auto of_body = times.find(sample.body);
    if (of_body == times.end()) continue;
    const std::vector<SessionTime>& hits = of_body->second;
    const auto next = std::upper_bound(hits.begin(), hits.end(), sample.time);
    if (next != hits.end() && *next - sample.time < ahead) {
      before.push_back(sample.distance);
      continue;
    }
    if (next == hits.begin()) continue;
    const double passed = seconds(sample.time - *(next - 1));
    (passed < delivery + AfterBlows::kSettle ? before : after).push_back(sample.distance);
  }
  result.before_m = distribution(before);
  result.after_m = distribution(after);
  return result;
}

}  // namespace tandem::demos
