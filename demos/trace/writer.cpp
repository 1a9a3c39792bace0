// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "trace/writer.h"

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

TraceWriter::TraceWriter(const TraceHeader& header) : checksum_(pbd::hash_bytes({})) {
  text(header.scene);
  varint(header.arguments.size());
  for (const std::string& argument : header.arguments) text(argument);
  varint(header.self);
  varint(header.number);
  u64(header.scene_hash);
  varint(header.bodies);
  text(header.build);
  pbd::ByteWriter out(out_);
  out.bytes(std::as_bytes(std::span(kTraceMagic)));
  out.u8(kTraceVersion);
  out.u32(static_cast<std::uint32_t>(payload_.size()));
  out.bytes(payload_);
  payload_.clear();
  sum_up(0);
  targets_before_.assign(header.bodies, 0);
  poses_before_.assign(header.bodies, 0);
}

void TraceWriter::write(const TraceRecord& record) {
  switch (record.kind) {
    case TraceKind::Packets:
      write_packets(record.call, record.packets);
      return;
    case TraceKind::Peers:
      peers(record);
      break;
    case TraceKind::Limit:
      varint(record.call);
      u8(static_cast<std::uint8_t>(record.delivery));
      varint(record.bytes);
      break;
    case TraceKind::Refused:
      varint(record.call);
      break;
    case TraceKind::User:
      varint(record.user);
      time(record.time);
      break;
    case TraceKind::Begin:
    case TraceKind::Step:
    case TraceKind::Finish:
    case TraceKind::Leave:
      time(record.time);
      break;
    case TraceKind::Inputs:
      inputs(record);
      break;
    case TraceKind::Solved:
      stage(record.targets, targets_before_);
      stage(record.poses, poses_before_);
      break;
    case TraceKind::Sent:
      u64(record.sent);
      break;
    case TraceKind::Rules:
      varint(record.arguments.size());
      for (const std::string& argument : record.arguments) text(argument);
      break;
    case TraceKind::End:
      varint(record.steps);
      u64(checksum_);
      break;
  }
  emit(record.kind);
}

void TraceWriter::write_packets(std::uint64_t call, std::span<const consensus::Packet> packets) {
  varint(call);
  varint(packets.size());
  for (const consensus::Packet& each : packets) packet(each);
  emit(TraceKind::Packets);
}

void TraceWriter::packet(const consensus::Packet& packet) {
  coded_.clear();
  const std::span<const std::byte> base = history_.like(packet.from, packet.bytes.size());
  if (!base.empty()) code_packet(packet.bytes, base, coded_);
  const bool coded = !coded_.empty() && coded_.size() < packet.bytes.size();
  const bool dated = packet.received != INT64_MIN;
  varint(packet.from);
  const int denied = static_cast<int>(consensus::Role::Share) - static_cast<int>(packet.role);
  u8(static_cast<std::uint8_t>((dated ? kDated : 0) | (coded ? kCoded : 0) |
                               denied << kDeniedShift));
  if (dated) {
    // Wraps for any value from a transport.
    signed_varint(static_cast<std::int64_t>(static_cast<std::uint64_t>(packet.received) -
                                            static_cast<std::uint64_t>(last_time_)));
  }
  varint(packet.bytes.size());
  pbd::ByteWriter(payload_).bytes(coded ? coded_ : packet.bytes);
  history_.remember(packet.from, packet.bytes);
}

void TraceWriter::peers(const TraceRecord& record) {
  varint(record.call);
  varint(record.peers.size());
  for (const consensus::PeerStatus& peer : record.peers) {
    varint(peer.id);
    u8(peer.connected ? 1 : 0);
    f64(peer.kbit_per_s);
    signed_varint(peer.round_trip);
    varint(peer.dropped_queue_full);
    varint(peer.rejected);
  }
}

void TraceWriter::inputs(const TraceRecord& record) {
  varint(record.user);
  varint(record.inputs.size());
  for (const Input& input : record.inputs) {
    u8(static_cast<std::uint8_t>(input.kind));
    varint(input.object);
    varint(input.body);
    for (const double value : input.values) f64(value);
  }
}

void TraceWriter::stage(const StageHash& stage, std::vector<std::uint32_t>& before) {
  u64(stage.all);
  const std::size_t mask = payload_.size();
  payload_.resize(mask + (before.size() + 7) / 8);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (stage.bodies[i] == before[i]) continue;
    payload_[mask + i / 8] |= static_cast<std::byte>(1u << (i % 8));
    pbd::ByteWriter(payload_).u32(stage.bodies[i]);
    before[i] = stage.bodies[i];
  }
}

void TraceWriter::signed_varint(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  varint(bits << 1 ^ (value < 0 ? ~std::uint64_t{0} : 0));
}

void TraceWriter::u64(std::uint64_t value) { pbd::ByteWriter(payload_).u64(value); }

void TraceWriter::f64(double value) { pbd::ByteWriter(payload_).f64(value); }

void TraceWriter::text(std::string_view value) {
  varint(value.size());
  pbd::ByteWriter(payload_).bytes(std::as_bytes(std::span(value)));
}

void TraceWriter::time(consensus::SessionTime value) {
  signed_varint(static_cast<std::int64_t>(static_cast<std::uint64_t>(value) -
                                          static_cast<std::uint64_t>(last_time_)));
  last_time_ = value;
}

void TraceWriter::emit(TraceKind kind) {
  const std::size_t first = out_.size();
  out_.push_back(static_cast<std::byte>(kind));
  write_varint(payload_.size(), out_);
  out_.insert(out_.end(), payload_.begin(), payload_.end());
  payload_.clear();
  sum_up(first);
}

void TraceWriter::sum_up(std::size_t first) {
  checksum_ = pbd::hash_bytes(std::span<const std::byte>(out_).subspan(first), checksum_);
}

}  // namespace tandem::demos
