// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "trace/packet_coding.h"
#include "trace/record.h"

namespace tandem::demos {

/// Encodes a trace; docs/trace.md has the format. The caller keeps TraceReader's order of records.
/// No allocation once its buffers have grown.
/// @par Thread safety  One object: one thread at a time.
class TraceWriter {
 public:
  /// bytes() then has the header.
  explicit TraceWriter(const TraceHeader& header);

  /// Appends a record; an End gets its checksum here.
  void write(const TraceRecord& record);
  /// The same for Packets outside a record.
  void write_packets(std::uint64_t call, std::span<const consensus::Packet> packets);

  /// The bytes since the last clear(), valid until the next record.
  std::span<const std::byte> bytes() const { return out_; }
  void clear() { out_.clear(); }

 private:
  void u8(std::uint8_t value) { payload_.push_back(static_cast<std::byte>(value)); }
  void varint(std::uint64_t value) { write_varint(value, payload_); }
  /// Short for values near 0.
  void signed_varint(std::int64_t value);
  void u64(std::uint64_t value);
  void f64(double value);
  void text(std::string_view value);
  void time(consensus::SessionTime value);
  void packet(const consensus::Packet& packet);
  void peers(const TraceRecord& record);
  void inputs(const TraceRecord& record);
  void stage(const StageHash& stage, std::vector<std::uint32_t>& before);
  void emit(TraceKind kind);
  /// Adds out_ from `first` on to the checksum.
  void sum_up(std::size_t first);

  std::vector<std::byte> out_;
  std::vector<std::byte> payload_;  ///< of the present record
  std::vector<std::byte> coded_;    ///< the present packet
  PacketHistory history_;
  std::uint64_t checksum_;
  consensus::SessionTime last_time_ = 0;
  std::vector<std::uint32_t> targets_before_, poses_before_;
};

}  // namespace tandem::demos
