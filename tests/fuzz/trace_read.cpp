// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What the demos read of traces.
#include <optional>

#include "replay/diff.h"
#include "replay/reader.h"
#include "scenes/inputs.h"
#include "target.h"
#include "trace/writer.h"

namespace fuzz {

using namespace tandem::demos;

namespace {

/// Writes down what the reader takes, up to what it refuses.
void copy(TraceReader& reader, TraceWriter& writer) {
  try {
    for (TraceRecord record; reader.next(record);) {
      require(record.targets.bodies.size() <= reader.header().bodies);
      for (const Input& each : record.inputs) require(broken_rule(each).empty());
      writer.write(record);
    }
  } catch (const TraceError&) {
  }
}

std::optional<TraceReader> reader_of(std::span<const std::byte> input) {
  try {
    return TraceReader(input);
  } catch (const TraceError&) {
    return std::nullopt;
  }
}

}  // namespace

void run(std::span<const std::byte> input) {
  std::optional<TraceReader> reader = reader_of(input);
  if (!reader) return;
  TraceReader original = *reader;
  TraceWriter writer(reader->header());
  copy(*reader, writer);
  // The reader must see the same in what it took, and refuse none of it.
  TraceReader again(writer.bytes());
  require(again.header() == original.header());
  require(!first_difference(again, original));
  require(again.offset() == writer.bytes().size() && again.complete() == reader->complete());
}

std::vector<Bytes> seeds() {
  TraceHeader header;
  header.scene = "cubes";
  header.arguments = {"--seed", "7"};
  header.self = 2;
  header.number = 1;
  header.bodies = 10;
  TraceWriter writer(header);
  const auto bytes = [&writer] { return Bytes(writer.bytes().begin(), writer.bytes().end()); };
  std::vector<Bytes> result{bytes()};
  TraceRecord record;
  const auto write = [&](TraceKind kind) {
    record.kind = kind;
    record.time += 1'000'000;
    writer.write(record);
  };
  record.bytes = 502;
  write(TraceKind::Limit);
  record.user = 1;
  write(TraceKind::User);
  write(TraceKind::Begin);
  record.packets = {{.from = 1, .bytes = Bytes(93, std::byte{5}), .received = 900'000}};
  record.packets.push_back(record.packets[0]);
  record.packets[1].bytes[40] = std::byte{6};  // told by what differs
  write(TraceKind::Packets);
  record.peers = {{.id = 1, .connected = true, .kbit_per_s = 64.0}};
  write(TraceKind::Peers);
  record.inputs = {{.kind = Input::Kind::Move, .object = 1, .body = 3, .values = {0.1, 0.2, 0.3}},
                   {.kind = Input::Kind::Jump,
                    .object = 2,
                    .body = 2,
                    .values = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}}};
  write(TraceKind::Inputs);
  write(TraceKind::Step);
  record.targets.bodies.assign(10, 7);
  record.poses.bodies.assign(10, 0);
  write(TraceKind::Solved);
  result.push_back(bytes());
  write(TraceKind::Finish);
  write(TraceKind::Refused);
  write(TraceKind::Sent);
  record.arguments = {"--coupling", "two-step"};
  write(TraceKind::Rules);
  write(TraceKind::Leave);
  write(TraceKind::Sent);
  record.steps = 1;
  write(TraceKind::End);
  result.push_back(bytes());
  return result;
}

}  // namespace fuzz
