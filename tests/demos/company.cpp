// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "company.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "measures/metrics.h"
#include "scenes/scenario_list.h"
#include "session/actor.h"

namespace tandem::demos::late_member_test {
namespace {

using consensus::SessionTime;

std::uint64_t awake(const pbd::World& world) {
  std::uint64_t count = 0;
  for (std::uint32_t slot = 0; slot < world.slot_count(); ++slot) {
    const bool moves = world.all_props()[slot].type == pbd::BodyType::Dynamic;
    count += moves && world.awake_at(slot) ? 1 : 0;
  }
  return count;
}

void compare(const Company& company, SessionTime from, Outcome& out) {
  std::span<const PeerRecord> compared(out.records);
  if (company.together > 0) compared = compared.first(static_cast<std::size_t>(company.together));
  std::vector<double> moving;
  std::vector<double> resting;
  for (const DivergenceSample& sample : divergence(compared)) {
    if (sample.time < from || sample.jumped || sample.object == ObjectClass::Owned) continue;
    (sample.object == ObjectClass::Resting ? resting : moving).push_back(sample.distance);
  }
  const Distribution found = distribution(moving);
  out.p50 = found.p50;
  out.p95 = found.p95;
  out.rest95 = distribution(resting).p95;
}

}  // namespace

Outcome run(const Company& company, const Saying* saying) {
  const auto scenario = make_scenario(company.scene);
  DemoOptions options;
  options.print = Print::Nothing;
  options.seconds = company.seconds;
  options.profile = company.profile;
  options.seed = company.seed;
  options.peers = company.honest;
  VirtualSession session(*scenario, options, nullptr);
  if (company.prepare) company.prepare(session);
  std::optional<LateMember> late;
  if (saying != nullptr) late.emplace(session, *saying);
  Outcome out;
  const auto ns = [](double seconds) { return kVirtualStart + std::llround(1e9 * seconds); };
  const SessionTime from = ns(LateMember::kSpeaks);
  std::vector<consensus::ReplayStats> before(session.actors().size());
  SessionTime last = 0;
  while (const auto now = session.act(ns(company.seconds))) {
    if (late) late->look(*now);
    if (*now == last) continue;
    if (last < from) {
      for (std::size_t i = 0; i < before.size(); ++i) {
        before[i] = session.actors()[i].participant().peer().stats().replay;
      }
    }
    last = *now;
    // All step at the same times.
    if (*now < from) continue;
    ++out.steps;
    for (Actor& actor : session.actors()) {
      out.body_steps += awake(*actor.participant().scene().world);
    }
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    Participant& participant = session.actors()[i].participant();
    out.records.push_back(participant.record());
    out.worlds.push_back(out.records.back().hash);
    const consensus::Peer& peer = participant.peer();
    consensus::ReplayStats& replay = out.replays.emplace_back(peer.stats().replay);
    replay.fresh -= before[i].fresh;
    replay.postponed -= before[i].postponed;
    replay.without -= before[i].without;
    replay.steps -= before[i].steps;
    replay.body_steps -= before[i].body_steps;
    out.body_steps += replay.body_steps;
    for (const consensus::PeerReport& report : peer.reports()) {
      if (report.peer != LateMember::kId) continue;
      out.late.push_back(report.late);
      out.without.push_back(report.without);
    }
  }
  compare(company, from, out);
  return out;
}

}  // namespace tandem::demos::late_member_test
