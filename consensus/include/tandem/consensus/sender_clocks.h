// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Arrival of a packet by the local clock, and the round trip to its sender, ns.
struct TANDEM_API Arrival {
  SessionTime received = 0;
  SessionTime round_trip = -1;  ///< -1: not known
};
/// @param peers  known to the transport   @param now  ns, used if the transport reports no time
TANDEM_API Arrival arrival_of(const Packet& packet, std::span<const PeerStatus> peers,
                              SessionTime now);

/// Estimates the offset of other peers' clocks from packet arrivals: for sessions without a common
/// time. All stamps of a sender are shifted by one offset, so that a packet is dated half a round
/// trip before its arrival. The offset is the median of the last kWindow stamps (which removes
/// jitter and single delays), approached with time constant kSettling and at most at kSlew:
/// differences between stamps of a sender are kept to 1 %. In the first second of a sender the
/// offset follows at once.
///
/// The error is half of the difference between the delays there and back, which cannot be observed,
/// plus some tenths of a millisecond of jitter; drift is followed. If a clock is set, or a process
/// restarts under its id, the estimate starts over after a moment in which its stamps are
/// meaningless. Stamps are untrusted: a sender shifts only its own.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API SenderClocks {
 public:
  SenderClocks();
  ~SenderClocks();
  SenderClocks(const SenderClocks&) = delete;
  SenderClocks& operator=(const SenderClocks&) = delete;

  static constexpr std::size_t kWindow = 128;
  static constexpr double kSettling = 2.0;  ///< s
  static constexpr double kSlew = 0.01;     ///< s per s
  /// This many samples in a row that do not fit, and if they are late for this many ns (a queue
  /// drains sooner), belong to another clock.
  static constexpr int kAstrayCount = 8;
  static constexpr SessionTime kAstrayFor = 1'000'000'000;
  /// ns: longer round trips are clamped.
  static constexpr SessionTime kLongestWay = 10'000'000'000;

  /// Register a packet.
  /// @param newest  ns, its newest stamp among those made when sending
  /// @param received  ns, own clock
  /// @param round_trip  ns, to the sender and back; < 0 = unknown, taken as 0
  /// @return ns, to be added to the stamps of this sender, see shifted()
  SessionTime hear(PeerId from, SessionTime newest, SessionTime received, SessionTime round_trip);
  /// ns, the result of the last hear(); nullopt if there was none.
  std::optional<SessionTime> shift(PeerId from) const;
  void forget(PeerId from);
  /// The offset by one packet alone.
  static SessionTime guess(SessionTime newest, SessionTime received, SessionTime round_trip);

 private:
  struct Sender;
  std::vector<Sender> senders_;  ///< by peer
};

/// The stamp with the shift, within kMaxStamp of 0.
TANDEM_API SessionTime shifted(SessionTime stamp, SessionTime shift);
/// Shift every stamp of a packet.
TANDEM_API void shift_stamps(DecodedPacket& packet, SessionTime shift);
/// Newest stamp among those made when sending: of states and Alive messages.
TANDEM_API std::optional<SessionTime> newest_stamp(const DecodedPacket& packet);
/// Newest stamp of all other records; 0 if there are none.
TANDEM_API SessionTime newest_stamp_of_others(const DecodedPacket& packet);

}  // namespace tandem::consensus
