// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/inputs.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

/// What a trace says before its first record.
struct TraceHeader {
  std::string scene;                   ///< the scenario's name
  std::vector<std::string> arguments;  ///< the run's options, as parse_options() reads them
  consensus::PeerId self = 0;
  std::uint64_t number = 0;      ///< of the peer, from 0: which noise, order and step rate it has
  std::uint64_t scene_hash = 0;  ///< see scene_hash()
  std::uint32_t bodies = 0;      ///< shared ones
  std::string build;             ///< see build_facts()
  friend bool operator==(const TraceHeader&, const TraceHeader&) = default;
};

/// Hashes after one stage of a step.
struct StageHash {
  std::uint64_t all = 0;
  std::vector<std::uint32_t> bodies;  ///< in the scene's order
  friend bool operator==(const StageHash&, const StageHash&) = default;
};

/// What a record is. User, Begin, Step, Finish, Leave, Rules and End each begin a phase; what the
/// transport answered in a phase follows in it.
enum class TraceKind : std::uint8_t {
  Packets = 1,  ///< came with a call of drain()
  Peers,        ///< peers() told something else than before
  Limit,        ///< max_packet_bytes() told something else than before
  Refused,      ///< post() returned false
  User,         ///< somebody sits down at this peer
  Begin,        ///< a step may begin
  Inputs,       ///< what one user did then
  Step,         ///< it is computed
  Solved,       ///< hashes after it
  Finish,       ///< its end has come
  Sent,         ///< hash of what was sent since the last one
  Leave,        ///< the peer leaves the session
  Rules,        ///< another peer, with other options, takes its place
  End,          ///< the trace is complete
};

/// One record; what its kind does not name has no meaning.
struct TraceRecord {
  TraceKind kind = TraceKind::End;
  /// Packets, Peers, Limit, Refused: of the calls of its kind in this phase, from 0.
  std::uint64_t call = 0;
  std::vector<consensus::Packet> packets;  ///< Packets
  /// Peers: id, connected, kbit_per_s, round_trip, dropped_queue_full and rejected alone.
  std::vector<consensus::PeerStatus> peers;
  consensus::Delivery delivery = consensus::Delivery::Newest;  ///< Limit
  std::uint64_t bytes = 0;                                     ///< Limit
  std::uint32_t user = 0;                                      ///< User, Inputs
  /// ns: Begin, Finish and Leave; Step: of its end; User: of the beginning of the user's script.
  consensus::SessionTime time = 0;
  std::vector<Input> inputs;           ///< Inputs; their time is not set
  StageHash targets;                   ///< Solved: what the step was told
  StageHash poses;                     ///< Solved: what came of it
  std::uint64_t sent = 0;              ///< Sent
  std::vector<std::string> arguments;  ///< Rules: as in the header
  std::uint64_t steps = 0;             ///< End: how many were solved
};

/// Whether a record begins a phase.
constexpr bool begins_phase(TraceKind kind) {
  return kind == TraceKind::User || kind == TraceKind::Begin || kind == TraceKind::Step ||
         kind == TraceKind::Finish || kind == TraceKind::Leave || kind == TraceKind::Rules ||
         kind == TraceKind::End;
}

/// Bytes that are no trace; what() names the offset and what must be there.
class TraceError : public std::runtime_error {
 public:
  TraceError(std::size_t offset, std::string_view what, std::string_view rule)
      : std::runtime_error("offset " + std::to_string(offset) + ": " +
                           pbd::detail::must_be(what, rule)) {}
};

// Flags of a packet.
inline constexpr std::uint8_t kDated = 1;  ///< the transport says when it came
inline constexpr std::uint8_t kCoded = 2;  ///< as it differs from the sender's last one as long
inline constexpr int kDeniedShift = 2;     ///< two bits: how far its role is below Share

inline constexpr std::string_view kTraceMagic = "TDMTRACE";
inline constexpr std::uint8_t kTraceVersion = 1;

}  // namespace tandem::demos
