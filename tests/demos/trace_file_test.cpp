// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Files of any origin are read as traces or refused.
#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "replay/replayer.h"
#include "runs.h"
#include "scenes/cubes.h"
#include "support/catch.h"
#include "trace_support.h"

namespace tandem::demos::trace_file_test {
namespace {

TEST_CASE("trace: a file that was cut off anywhere is replayed as far as it goes",
          "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 0.4)).traces[0];
  const TraceHeader header = TraceReader(trace).header();
  const std::size_t header_size = bytes_of(header, {}).size();
  std::uint64_t steps = 0;
  for (std::size_t length = 0; length < trace.size(); ++length) {
    const Bytes cut(trace.begin(), trace.begin() + static_cast<std::ptrdiff_t>(length));
    try {
      TraceReader reader(cut);
      for (TraceRecord record; reader.next(record);) {
      }
      CHECK(length >= header_size);
      CHECK_FALSE(reader.complete());
      CHECK(reader.steps() >= steps);
      steps = reader.steps();
    } catch (const TraceError&) {
      CHECK(length < header_size);
    }
  }
  CHECK(steps == records_of(trace).back().steps);
  // As a crash within the 20th step leaves it: what the step was told is there, its hashes not.
  const std::vector<TraceRecord> records = records_of(trace);
  std::vector<TraceRecord> until;
  for (std::size_t i = 0; step_of(records, i) < 20; ++i) until.push_back(records[i]);
  until.pop_back();
  const Replay again = replay(scenario, bytes_of(header, until));
  CHECK_FALSE(again.departure);
  CHECK(again.steps == 20);
}

TEST_CASE("trace: a file that is no trace is refused by offset and rule", "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  const Bytes trace = traced_run(scenario, quiet(3, 0.2)).traces[0];
  const auto refusal = [](const Bytes& bytes) -> std::string {
    try {
      records_of(bytes);
    } catch (const TraceError& error) {
      return error.what();
    }
    return {};
  };
  CHECK(refusal(trace).empty());
  CHECK(refusal({}).find("offset 0: file must be") == 0);
  Bytes bad = trace;
  bad[3] ^= std::byte{1};
  CHECK(refusal(bad).find("offset 0: magic must be") == 0);
  bad = trace;
  bad[8] = std::byte{77};
  CHECK(refusal(bad).find("is 77") != std::string::npos);
  // A bit that no rule minds is found by the checksum.
  bad = altered(trace, [](auto& all) { all.pop_back(); });
  const std::size_t last = bad.size() - 1;
  bad = trace;
  bad[last] ^= std::byte{0x10};
  CHECK(refusal(bad).find("checksum must be") != std::string::npos);
  // Order.
  const auto without_first = [&](TraceKind kind) {
    return altered(trace, [kind](auto& all) {
      const auto at = std::find_if(all.begin(), all.end(),
                                   [kind](const auto& each) { return each.kind == kind; });
      REQUIRE(at != all.end());
      all.erase(at);
    });
  };
  for (const TraceKind kind :
       {TraceKind::Begin, TraceKind::Step, TraceKind::Solved, TraceKind::Finish, TraceKind::Sent}) {
    CHECK(refusal(without_first(kind)).find("record must be in its order") != std::string::npos);
  }
  // Another scene.
  const CubesScenario other;
  CHECK_THROWS_AS(Replayer(other, trace), std::invalid_argument);
}

TEST_CASE("trace: few bytes stand for no more packets than a phase may have", "[demos][fault]") {
  TraceHeader header;
  header.scene = "cubes";
  header.self = 1;
  // All but the first are told by what differs: nothing.
  constexpr std::size_t kMebibyte = std::size_t{1} << 20;
  TraceRecord packet;
  packet.kind = TraceKind::Packets;
  packet.packets = {{.from = 2, .bytes = Bytes(kMebibyte, std::byte{1})}};
  TraceRecord begin;
  begin.kind = TraceKind::Begin;
  begin.time = 1;
  const auto read = [&](int count, bool one_phase) {
    TraceWriter writer(header);
    for (int i = 0; i < count; ++i) {
      if (!one_phase) writer.write(begin);
      writer.write(packet);
    }
    CHECK(writer.bytes().size() < 2 * kMebibyte);
    TraceReader reader(writer.bytes());
    int packets = 0;
    for (TraceRecord record; reader.next(record);) {
      packets += record.kind == TraceKind::Packets ? 1 : 0;
    }
    return packets;
  };
  CHECK(read(64, true) == 64);
  CHECK_THROWS_AS(read(65, true), TraceError);
  CHECK(read(65, false) == 65);
}

TEST_CASE("trace: mutated traces are replayed or refused, and nothing else happens",
          "[demos][fault]") {
  const CubesScenario scenario(kSmall);
  DemoOptions options = quiet(3, 0.3);
  const Bytes trace = traced_run(scenario, options).traces[1];
  const std::vector<TraceRecord> records = records_of(trace);
  std::uint64_t state = 1;
  const auto below = [&state](std::size_t limit) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>(state >> 33) % limit;
  };
  std::size_t departed = 0;
  std::size_t refused = 0;
  for (int i = 0; i < 150; ++i) {
    Bytes bad = trace;
    for (std::size_t k = 0; k <= below(3); ++k) bad[below(bad.size())] = std::byte(below(256));
    if (below(4) == 0) bad.resize(below(bad.size()));
    try {
      departed += replay(scenario, bad).departure ? 1 : 0;
    } catch (const TraceError&) {
      ++refused;
    } catch (const std::invalid_argument&) {  // options, or the scene
      ++refused;
    }
  }
  CHECK(departed > 10);
  CHECK(refused > 10);
}

}  // namespace
}  // namespace tandem::demos::trace_file_test
