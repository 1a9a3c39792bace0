// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "trace/packet_coding.h"
#include "trace/record.h"

namespace tandem::demos {

/// Reads a trace from any source: validates all input and the order of records in docs/trace.md.
/// Memory is bounded by the size of the trace.
/// @par Thread safety  One object: one thread at a time.
class TraceReader {
 public:
  /// Reads the header. The bytes must outlive the reader. @throws TraceError
  explicit TraceReader(std::span<const std::byte> bytes);

  const TraceHeader& header() const { return header_; }
  /// Reads the next record into `record`, reusing its memory except for packets. False at the end,
  /// and if the trace was cut off there.
  /// @throws TraceError
  bool next(TraceRecord& record);
  /// True once the End has been read.
  bool complete() const { return state_ == State::Ended; }
  /// Offset of the last record, or of the place without one.
  std::size_t offset() const { return offset_; }
  /// Number of solved steps so far.
  std::uint64_t steps() const { return steps_; }

 private:
  class In;
  /// The last event.
  enum class State : std::uint8_t { Idle, Begun, Stepping, Solved, Finished, Ended };

  void read_header();
  void read(In& in, TraceRecord& record);
  void read_packets(In& in, TraceRecord& record);
  void read_peers(In& in, TraceRecord& record);
  void read_inputs(In& in, TraceRecord& record);
  void read_stage(In& in, StageHash& stage, std::vector<std::uint32_t>& before);
  void read_end(In& in, TraceRecord& record);
  consensus::SessionTime read_time(In& in);
  /// Checks that the record may come now, and updates the state.
  void follow(In& in, const TraceRecord& record);

  std::span<const std::byte> bytes_;
  TraceHeader header_;
  std::size_t at_ = 0;
  std::size_t offset_ = 0;
  PacketHistory history_;
  std::uint64_t phase_bytes_ = 0;  ///< bytes of this phase's packets so far
  std::uint64_t checksum_;         ///< of all bytes before at_
  std::uint64_t steps_ = 0;
  consensus::SessionTime last_time_ = 0;
  consensus::SessionTime begun_ = 0;
  State state_ = State::Idle;
  std::vector<std::uint32_t> users_;
  std::vector<std::uint32_t> targets_before_, poses_before_;
};

}  // namespace tandem::demos
