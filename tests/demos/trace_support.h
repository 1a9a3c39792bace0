// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/reader.h"
#include "replay/replayer.h"
#include "runner/virtual_runner.h"
#include "scenes/cubes.h"
#include "scenes/scenario.h"
#include "session/options.h"
#include "session/track.h"
#include "support/catch.h"
#include "support/folder.h"
#include "trace/writer.h"

namespace tandem::demos {

using testing::Folder;

using Bytes = std::vector<std::byte>;

inline Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file);
  const std::vector<char> content{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(content));
  return {bytes.begin(), bytes.end()};
}

/// Half as many stacks on half a plate, to be quick.
inline const CubesOptions kSmall{.stacks = 2, .height = 3, .plate = pbd::Vec3(0.8, 0.8, 0.04)};

/// A run in virtual time and its traces, by peer.
struct TracedRun {
  RunResult result;
  std::vector<Bytes> traces;
};

inline TracedRun traced_run(const Scenario& scenario, DemoOptions options) {
  const Folder folder;
  options.trace = folder.file("trace");
  TracedRun run;
  run.result = run_virtual(scenario, options);
  for (std::size_t i = 0; i < run.result.peers.size(); ++i) {
    run.traces.push_back(read_bytes(options.trace + '.' + std::to_string(i + 1)));
  }
  return run;
}

/// A run of a trace to its end, or to where it departs.
struct Replay {
  std::uint64_t steps = 0;
  std::optional<Departure> departure;
  std::uint64_t hash = 0;  ///< of the world at the end
};

inline Replay replay(const Scenario& scenario, const Bytes& trace) {
  Replayer replayer(scenario, trace);
  while (replayer.next_step()) {
  }
  return {replayer.steps(), replayer.departure(), replayer.scene().world->hash()};
}

/// The records of a trace.
inline std::vector<TraceRecord> records_of(const Bytes& trace) {
  TraceReader reader(trace);
  std::vector<TraceRecord> records;
  for (TraceRecord record; reader.next(record);) records.push_back(record);
  return records;
}

inline Bytes bytes_of(const TraceHeader& header, const std::vector<TraceRecord>& records) {
  TraceWriter writer(header);
  for (const TraceRecord& record : records) writer.write(record);
  return {writer.bytes().begin(), writer.bytes().end()};
}

/// The trace with something else in it, as if it had been written like that.
inline Bytes altered(const Bytes& trace,
                     const std::function<void(std::vector<TraceRecord>&)>& alter) {
  std::vector<TraceRecord> records = records_of(trace);
  alter(records);
  return bytes_of(TraceReader(trace).header(), records);
}

/// The number of the step that a record belongs to.
inline std::uint64_t step_of(const std::vector<TraceRecord>& records, std::size_t record) {
  std::uint64_t step = 0;
  for (std::size_t i = 0; i < record; ++i) step += records[i].kind == TraceKind::Solved ? 1 : 0;
  return step;
}

}  // namespace tandem::demos
