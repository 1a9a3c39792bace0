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

struct TraceHeader {
  std::string scene;                   ///< the scenario's name
  std::vector<std::string> arguments;  ///< the run's options, as parse_options() reads them
  consensus::PeerId self = 0;
  std::uint64_t number = 0;      ///< of the peer, from 0: selects noise, order and step rate
  std::uint64_t scene_hash = 0;  ///< see scene_hash()
  std::uint32_t bodies = 0;      ///< number of shared bodies
  std::string build;             ///< see build_facts()
  friend bool operator==(const TraceHeader&, const TraceHeader&) = default;
};

struct StageHash {
  std::uint64_t all = 0;
  std::vector<std::uint32_t> bodies;  ///< in the scene's order
  friend bool operator==(const StageHash&, const StageHash&) = default;
};

/// User, Begin, Step, Finish, Leave, Rules and End each begin a phase; the transport's answers in a
/// phase follow within it.
enum class TraceKind : std::uint8_t {
  Packets = 1,  ///< returned by a call of drain()
  Peers,        ///< peers() changed
  Limit,        ///< max_packet_bytes() changed
  Refused,      ///< post() returned false
  User,         ///< a user joins this peer
  Begin,        ///< a step may begin
  Inputs,       ///< one user's inputs for it
  Step,         ///< it is computed
  Solved,       ///< hashes after it
  Finish,       ///< its end has come
  Sent,         ///< hash of the packets sent since the last one
  Leave,        ///< the peer leaves the session
  Rules,        ///< another peer, with other options, replaces it
  End,          ///< the trace is complete
};

/// One record; fields that its kind does not name are unused.
struct TraceRecord {
  TraceKind kind = TraceKind::End;
  /// Packets, Peers, Limit, Refused: index of the call of its kind in this phase.
  std::uint64_t call = 0;
  std::vector<consensus::Packet> packets;  ///< Packets
  /// Peers: only id, connected, kbit_per_s, round_trip, dropped_queue_full and rejected.
  std::vector<consensus::PeerStatus> peers;
  consensus::Delivery delivery = consensus::Delivery::Newest;  ///< Limit
  std::uint64_t bytes = 0;                                     ///< Limit
  std::uint32_t user = 0;                                      ///< User, Inputs
  /// ns: Begin, Finish and Leave; Step: its end; User: the beginning of the user's script.
  consensus::SessionTime time = 0;
  std::vector<Input> inputs;           ///< Inputs; their time is not set
  StageHash targets;                   ///< Solved: input of the step
  StageHash poses;                     ///< Solved: result of the step
  std::uint64_t sent = 0;              ///< Sent
  std::vector<std::string> arguments;  ///< Rules: as in the header
  std::uint64_t steps = 0;             ///< End: number of solved steps
};

constexpr bool begins_phase(TraceKind kind) {
  return kind == TraceKind::User || kind == TraceKind::Begin || kind == TraceKind::Step ||
         kind == TraceKind::Finish || kind == TraceKind::Leave || kind == TraceKind::Rules ||
         kind == TraceKind::End;
}

/// Invalid bytes; what() names offset and rule.
class TraceError : public std::runtime_error {
 public:
  TraceError(std::size_t offset, std::string_view what, std::string_view rule)
      : std::runtime_error("offset " + std::to_string(offset) + ": " +
                           pbd::detail::must_be(what, rule)) {}
};

inline constexpr std::uint8_t kDated = 1;  ///< the transport knows its time of arrival
inline constexpr std::uint8_t kCoded = 2;  ///< relative to an earlier packet
inline constexpr int kDeniedShift = 2;     ///< two bits: distance of its role below Share

inline constexpr std::string_view kTraceMagic = "TDMTRACE";
inline constexpr std::uint8_t kTraceVersion = 1;

}  // namespace tandem::demos
