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

/// When a packet came, by the own clock, and how long to its sender and back takes, ns.
struct TANDEM_API Arrival {
  SessionTime received = 0;
  SessionTime round_trip = -1;  ///< -1: not known
};
/// @param peers  whom the transport knows     @param now  ns, where the transport does not say
TANDEM_API Arrival arrival_of(const Packet& packet, std::span<const PeerStatus> peers,
                              SessionTime now);

/// What the clocks of others show, told from when their packets come: for sessions without a common
/// time. All stamps of a sender are shifted by one number, so that what is stamped when it is sent
/// is dated half a round trip before it comes. The number is the median of the last kWindow stamps
/// (jitter goes, and what is late for once), taken over in kSettling, by at most kSlew: differences
/// between stamps of a sender stay what they are to 1 %. In the first second of a sender it follows
/// at once.
///
/// The error is half of the difference between the ways there and back, which cannot be seen, and
/// some tenths of a millisecond of jitter; what drifts is followed. A clock that is set, or a
/// process that starts again under its id, is begun with anew after a moment in which its stamps
/// mean nothing. Stamps are untrusted: a sender moves nothing but its own.
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
  /// So many samples in a row that fit nothing before, and where they are late over so many ns (a
  /// queue that is let go is over sooner), are of another clock.
  static constexpr int kAstrayCount = 8;
  static constexpr SessionTime kAstrayFor = 1'000'000'000;
  /// ns: no round trip is longer.
  static constexpr SessionTime kLongestWay = 10'000'000'000;

  /// A packet has come.
  /// @param newest      ns, its newest stamp among those that are stamped when they are sent
  /// @param received    ns, own clock
  /// @param round_trip  ns, to the sender and back; < 0: not known, none is assumed
  /// @return ns, to be added to the stamps of this sender, see shifted()
  SessionTime hear(PeerId from, SessionTime newest, SessionTime received, SessionTime round_trip);
  /// ns, the same as the last one; nullopt where nothing was heard.
  std::optional<SessionTime> shift(PeerId from) const;
  void forget(PeerId from);
  /// What one packet alone says.
  static SessionTime guess(SessionTime newest, SessionTime received, SessionTime round_trip);

 private:
  struct Sender;
  std::vector<Sender> senders_;  ///< by peer
};

/// The stamp with the shift, within kMaxStamp of 0.
TANDEM_API SessionTime shifted(SessionTime stamp, SessionTime shift);
/// Shift every stamp of a packet.
TANDEM_API void shift_stamps(DecodedPacket& packet, SessionTime shift);
/// Newest stamp of what is stamped when it is sent: states, and words that the sender is there.
TANDEM_API std::optional<SessionTime> newest_stamp(const DecodedPacket& packet);
/// Newest stamp of everything else; 0 where there is none.
TANDEM_API SessionTime newest_stamp_of_others(const DecodedPacket& packet);

}  // namespace tandem::consensus
