// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Where a replay is not as its trace, or two traces are not the same.
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/diff.h"
#include "runs.h"
#include "scenes/cubes.h"
#include "support/catch.h"
#include "tandem/consensus/update.h"
#include "trace_support.h"

namespace tandem::demos::trace_diff_test {
namespace {

/// A place in a packet, and the body whose position is there.
struct Place {
  std::size_t record = 0;
  std::size_t byte = 0;
  consensus::SharedId body;
};

/// Where a flip of one bit changes the position of one body and nothing else, by the codec's
/// account. The sender leads on it: nobody sleeps through that, nobody is deaf to it.
Place place_in_states(const std::vector<TraceRecord>& records) {
  for (std::size_t r = 0; r < records.size(); ++r) {
    if (records[r].kind != TraceKind::Packets) continue;
    const Bytes& packet = records[r].packets[0].bytes;
    consensus::DecodedPacket honest;
    if (!consensus::decode(packet, honest).ok()) continue;
    const auto led = std::find_if(
        honest.states.begin(), honest.states.end(),
        [](const auto& state) { return state.flags.leads && state.twist.linear.norm() > 0.05; });
    if (led == honest.states.end()) continue;
    const auto k = static_cast<std::size_t>(led - honest.states.begin());
    for (std::size_t byte = 0; byte < packet.size(); ++byte) {
      Bytes flipped = packet;
      flipped[byte] ^= std::byte{1};
      consensus::DecodedPacket other;
      if (!consensus::decode(flipped, other).ok()) continue;
      if (other.states.size() != honest.states.size()) continue;
      const pbd::Vec3 moved = other.states[k].pose.position - honest.states[k].pose.position;
      // Enough to be more than what peers leave alone.
      if (moved.norm() > 2.0 * consensus::ReplayOptions{}.tolerance && moved.norm() < 1e-3)
        return {r, byte, honest.states[k].id};
    }
  }
  FAIL("nobody leads");
  return {};
}

TEST_CASE("trace: one bit of one packet is found at its step, stage and body", "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  for (const Scheme scheme : {Scheme::OnePass, Scheme::TwoStep}) {
    DemoOptions options = quiet(3, 5.0);
    options.scheme = scheme;
    const Bytes trace = traced_run(scenario, options).traces[0];
    const std::vector<TraceRecord> records = records_of(trace);
    const Place place = place_in_states(records);
    const std::uint64_t step = step_of(records, place.record);
    const Bytes fault = altered(
        trace, [&](auto& all) { all[place.record].packets[0].bytes[place.byte] ^= std::byte{1}; });

    const std::optional<Departure> departure = replay(scenario, fault).departure;
    REQUIRE(departure);
    CHECK(departure->step == step);
    CHECK(departure->stage == "targets");
    REQUIRE(departure->body);
    CHECK(scenario.build({}).bodies[*departure->body].id == place.body);
    CHECK(departure->bodies == 1);

    TraceReader a(trace);
    TraceReader b(fault);
    const std::optional<Departure> difference = first_difference(a, b);
    REQUIRE(difference);
    CHECK(difference->step == step);
    CHECK(difference->stage == "packets");
    CHECK(difference->note.find("from peer 2, byte " + std::to_string(place.byte)) !=
          std::string::npos);
  }
}

TEST_CASE("trace: one bit of one input is found at its step, stage and body", "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 3.0)).traces[0];
  const std::vector<TraceRecord> records = records_of(trace);
  const auto moves = [](const TraceRecord& record) {
    return record.kind == TraceKind::Inputs && record.inputs.size() == 3 &&
           record.inputs[1].kind == Input::Kind::Move;
  };
  const auto found = std::find_if(records.begin(), records.end(), moves);
  REQUIRE(found != records.end());
  const auto at = static_cast<std::size_t>(found - records.begin());
  const Bytes fault = altered(trace, [&](auto& all) {
    double& x = all[at].inputs[1].values[0];
    x = std::nextafter(x, 100.0);
  });
  const std::optional<Departure> departure = replay(scenario, fault).departure;
  REQUIRE(departure);
  CHECK(departure->step == step_of(records, at));
  CHECK(departure->stage == "targets");
  CHECK(departure->body == found->inputs[1].body);
  CHECK(departure->bodies == 1);

  TraceReader a(trace);
  TraceReader b(fault);
  const std::optional<Departure> difference = first_difference(a, b);
  REQUIRE(difference);
  CHECK(difference->stage == "inputs");
  CHECK(difference->body == found->inputs[1].body);
}

TEST_CASE("trace: where programs compute other things, a diff tells step, stage and body",
          "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 1.0)).traces[1];
  const std::vector<TraceRecord> records = records_of(trace);
  std::vector<std::size_t> solved;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].kind == TraceKind::Solved) solved.push_back(i);
  }
  const auto difference = [&](const std::function<void(TraceRecord&)>& alter) {
    const Bytes other = altered(trace, [&](auto& all) { alter(all[solved[40]]); });
    TraceReader a(trace);
    TraceReader b(other);
    return first_difference(a, b).value();
  };
  const Departure poses = difference([](TraceRecord& record) { record.poses.bodies[3] ^= 1; });
  CHECK(poses.step == 40);
  CHECK(poses.stage == "poses");
  CHECK(poses.body == 3u);
  const Departure targets = difference([](TraceRecord& record) {
    record.targets.bodies[4] ^= 1;
    record.poses.bodies[3] ^= 1;
  });
  CHECK(targets.stage == "targets");
  CHECK(targets.body == 4u);
  // And the replay says the same of a program that does not compute what is in the file.
  const Bytes other = altered(trace, [&](auto& all) { all[solved[40]].poses.bodies[3] ^= 1; });
  const std::optional<Departure> departure = replay(scenario, other).departure;
  REQUIRE(departure);
  CHECK(departure->step == 40);
  CHECK(departure->stage == "poses");
  CHECK(departure->body == 3u);
  // The same run twice is the same.
  TraceReader a(trace);
  TraceReader b(trace);
  CHECK_FALSE(first_difference(a, b));
}

TEST_CASE("trace: two peers' copies are as far apart in their replays as they were in the run",
          "[demos][unit]") {
  const CubesScenario scenario(kSmall);
  const TracedRun run = traced_run(scenario, quiet(5, 3.0));
  // By the tracks of the run itself.
  const PeerRecord& one = run.result.peers[0];
  const PeerRecord& two = run.result.peers[1];
  double furthest = 0.0;
  std::size_t body = 0;
  for (std::size_t i = 0; i < one.tracks.size(); ++i) {
    // The first sample is of the beginning, before any step.
    const std::span here = std::span(one.tracks[i].samples()).subspan(1);
    const std::span there = std::span(two.tracks[i].samples()).subspan(1);
    for (const TrackSample& sample : here) {
      const auto after =
          std::find_if(there.begin(), there.end(),
                       [&sample](const TrackSample& each) { return each.time >= sample.time; });
      if (after == there.begin() || after == there.end()) continue;
      const TrackSample& before = *(after - 1);
      const double part = static_cast<double>(sample.time - before.time) /
                          static_cast<double>(after->time - before.time);
      const pbd::Vec3 position = (1.0 - part) * before.position + part * after->position;
      const double distance = (position - sample.position).norm();
      if (distance > furthest) body = i;
      furthest = std::max(furthest, distance);
    }
  }
  const TwoViews views = compare_views(scenario, run.traces[0], run.traces[1], 0.5 * furthest);
  CHECK_FALSE(views.a);
  CHECK_FALSE(views.b);
  REQUIRE(views.furthest);
  CHECK(views.furthest->distance == Approx(furthest).epsilon(1e-9));
  CHECK(views.furthest->body == body);
  REQUIRE(views.beyond);
  CHECK(views.beyond->distance > 0.5 * furthest);
  CHECK(views.beyond->time <= views.furthest->time);
  CHECK_FALSE(compare_views(scenario, run.traces[0], run.traces[1], 1.1 * furthest).beyond);
}

}  // namespace
}  // namespace tandem::demos::trace_diff_test
