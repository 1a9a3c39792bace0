// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "beside/networks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <utility>

#include "measures/metrics.h"
#include "runner/virtual_session.h"
#include "scenes/scenario_list.h"
#include "session/actor.h"

namespace tandem::beside_bench {
namespace {

using consensus::SessionTime;

constexpr std::size_t kHis = demos::DemoOptions::kOnNetwork - 1;  ///< of the troubled peer
constexpr double kNear = 1e-3;                                    ///< m

SessionTime at(double seconds) { return demos::kVirtualStart + std::llround(1e9 * seconds); }

/// Trouble of the machine, applied during the bad time.
using Machine = std::function<void(demos::Actor& his, SessionTime now)>;

struct Trouble {
  std::string name;
  std::string network = {};
  Machine machine = {};
  double hz = 60.0;  ///< all the time
};

std::vector<Trouble> troubles() {
  std::vector<Trouble> out;
  out.push_back({.name = "none"});
  for (const consensus::NamedNetwork& network : consensus::named_networks()) {
    out.push_back({.name = std::string(network.name), .network = std::string(network.name)});
  }
  out.push_back({.name = "half of real time", .machine = [](demos::Actor& his, SessionTime now) {
                   his.sleep_until(now + 1'000'000'000 / 60);
                 }});
  out.push_back({.name = "a locked phone",
                 .machine = [](demos::Actor& his, SessionTime) { his.sleep_until(at(kTo)); }});
  out.push_back({.name = "15 steps a second", .hz = 15.0});
  return out;
}

std::vector<demos::PeerRecord> run(const std::string& scene, std::uint64_t seed,
                                   const Trouble& trouble) {
  const auto scenario = demos::make_scenario(scene);
  demos::DemoOptions options;
  options.print = demos::Print::Nothing;
  options.seconds = kEnd;
  options.profile = 2;
  options.peers = 4;
  options.seed = seed;
  options.rates = {60.0, trouble.hz, 60.0, 60.0};
  demos::VirtualSession session(*scenario, options, nullptr);
  while (session.act(at(kFrom))) {
  }
  options.network = trouble.network;
  options.set_links(session.network());
  demos::Actor& his = session.actors()[kHis];
  while (const auto now = session.act(at(kTo))) {
    const auto [next, kind] = his.next();
    if (trouble.machine && kind == 1 && next == *now) trouble.machine(his, *now);
  }
  options.network.clear();
  options.set_links(session.network());
  while (session.act(at(kEnd))) {
  }
  std::vector<demos::PeerRecord> records;
  for (demos::Actor& actor : session.actors()) records.push_back(actor.participant().record());
  return records;
}

/// m: distance of a copy from the others' at its own time.
double off(std::span<const demos::PeerRecord> records, std::size_t body,
           const demos::TrackSample& copy) {
  double most = 0.0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (i == kHis) continue;
    const auto there = records[i].tracks[body].at(copy.time);
    if (there) most = std::max(most, (there->position - copy.position).norm());
  }
  return most;
}

/// m: largest shift of the troubled peer's copies in a step, beyond velocity and previous error.
double leap(std::span<const demos::PeerRecord> records) {
  double most = 0.0;
  const demos::PeerRecord& his = records[kHis];
  for (std::size_t body = 0; body < his.tracks.size(); ++body) {
    if (his.owned(body)) continue;
    const std::vector<demos::TrackSample>& way = his.tracks[body].samples();
    for (std::size_t i = 1; i < way.size(); ++i) {
      const demos::TrackSample& from = way[i - 1];
      const demos::TrackSample& to = way[i];
      if (from.time < at(kTo) || to.time > at(kTo + 2.0)) continue;
      const double dt = 1e-9 * static_cast<double>(to.time - from.time);
      const double moved = (to.position - from.position).norm();
      const double goes = dt * std::max(from.speed, to.speed);
      most = std::max(most, moved - goes - off(records, body, from));
    }
  }
  return most;
}

/// True if its hand held a body recently: the others may have heard of it at different times.
bool held_lately(const demos::Track& his, SessionTime time) {
  constexpr SessionTime kLate = 2'500'000'000;  // ns: a stall, and the time until all agree again
  const std::vector<demos::TrackSample>& way = his.samples();
  auto sample = std::upper_bound(way.begin(), way.end(), time,
                                 [](SessionTime t, const auto& s) { return t < s.time; });
  while (sample != way.begin() && (--sample)->time >= time - kLate) {
    if (sample->users > 0) return true;
  }
  return false;
}

struct Seen {
  double moving = 0.0, resting = 0.0;  ///< m, maximum after the trouble
};

Troubled judge(std::span<const demos::PeerRecord> records, const Seen* usual, Seen& seen) {
  Troubled out;
  const std::array<demos::PeerRecord, 3> rest = {records[0], records[2], records[3]};
  std::vector<double> moving;
  for (const demos::DivergenceSample& sample : demos::divergence(rest)) {
    if (sample.time < at(kFrom) || sample.jumped) continue;
    if (sample.object == demos::ObjectClass::Owned) continue;
    if (held_lately(records[kHis].tracks[sample.body], sample.time)) continue;
    if (sample.object != demos::ObjectClass::Resting) moving.push_back(sample.distance);
  }
  out.others = demos::distribution(moving).p95;
  for (const demos::DivergenceSample& sample : demos::divergence(records)) {
    if (sample.jumped || sample.object == demos::ObjectClass::Owned) continue;
    const double after = 1e-9 * static_cast<double>(sample.time - at(kTo));
    const bool rests = sample.object == demos::ObjectClass::Resting;
    if (sample.time >= at(kFrom) && after <= 0.0) out.gap = std::max(out.gap, sample.distance);
    if (after <= 0.0) continue;
    double& most = rests ? seen.resting : seen.moving;
    most = std::max(most, sample.distance);
    if (usual == nullptr) continue;
    const double bound = 1.5 * (rests ? usual->resting : usual->moving) + kNear;
    if (sample.distance > bound) {
      double& when = rests ? out.at_rest : out.together;
      when = std::max(when, after);
    }
  }
  out.leap = leap(records);
  return out;
}

}  // namespace

std::vector<Troubled> troubled(const std::string& scene, std::uint64_t seed) {
  std::vector<Troubled> out;
  Seen usual;
  for (const Trouble& trouble : troubles()) {
    const std::vector<demos::PeerRecord> records = run(scene, seed, trouble);
    Seen seen;
    Troubled& line = out.emplace_back(judge(records, out.empty() ? nullptr : &usual, seen));
    if (out.size() == 1) usual = seen;
    line.scene = scene;
    line.trouble = trouble.name;
    // Lasting trouble has no time after it.
    if (trouble.hz != 60.0) line.together = line.at_rest = -1.0;
  }
  return out;
}

}  // namespace tandem::beside_bench
