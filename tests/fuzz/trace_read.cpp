// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What the demos read of traces.
#include "scenes/inputs.h"
#include "target.h"
#include "trace/reader.h"
#include "trace/writer.h"

namespace fuzz {

using namespace tandem::demos;

void run(std::span<const std::byte> input) {
  try {
    TraceReader reader(input);
    // What was taken is written again: the reader must have seen the same in it.
    TraceWriter writer(reader.header());
    std::vector<TraceRecord> records;
    for (TraceRecord record; reader.next(record);) {
      require(record.targets.bodies.size() <= reader.header().bodies);
      for (const Input& each : record.inputs) require(broken_rule(each).empty());
      if (record.kind == TraceKind::End) break;
      writer.write(record);
      records.push_back(record);
    }
    TraceReader again(writer.bytes());
    require(again.header() == reader.header());
    TraceRecord record;
    for (const TraceRecord& each : records) {
      require(again.next(record) && record.kind == each.kind && record.time == each.time);
      require(record.targets == each.targets && record.poses == each.poses);
      require(record.arguments == each.arguments);
      require(record.packets.size() == each.packets.size());
      for (std::size_t i = 0; i < each.packets.size(); ++i) {
        require(record.packets[i].from == each.packets[i].from);
        require(record.packets[i].received == each.packets[i].received);
        require(record.packets[i].bytes == each.packets[i].bytes);
      }
    }
    require(!again.next(record));
  } catch (const TraceError&) {
  }
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
