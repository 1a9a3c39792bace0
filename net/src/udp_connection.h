// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "channels.h"
#include "clock_turns.h"
#include "handshake.h"
#include "pacing.h"
#include "packet_protection.h"

namespace tandem::net {

struct UdpConnectionOptions {
  ChannelOptions channels;
  CongestionOptions congestion;
  RekeyPolicy rekey;
  /// upper limit of the path MTU search, in [548, kMaxDatagram]; 548 for an MTU of 576
  std::size_t max_datagram = kMaxDatagram;
  std::int64_t idle_timeout = 5'000'000'000;
};

/// One connection after its handshake: datagrams in, datagrams out, messages for the application.
/// No socket and no clock; times are ns of any monotonic clock.
class UdpConnection {
 public:
  enum class State { Open, Leaving, Closed };

  /// @param began_here  false: nothing is sent before the other end is confirmed, else its address
  /// would get more than came from there
  UdpConnection(const Session& session, const UdpConnectionOptions& options, bool began_here,
                std::int64_t now);
  /// ns: a peer that has answered a handshake confirms its keys within this time, or has forgotten
  /// it.
  static constexpr std::int64_t kConfirmTime = 2'000'000'000;

  /// False if it is dropped at once: closed, too long, queue of reliable messages full.
  bool post(std::span<const std::byte> bytes, consensus::Delivery delivery, std::int64_t now);

  /// The next datagram to send, empty if none is due. Valid until the next call. Call until it is
  /// empty. @param clock  the local clock at `now`; null: never sent
  std::span<const std::byte> poll(std::int64_t now, const ClockClaim* clock = nullptr);
  /// When poll() will return a datagram, if nothing comes or is posted before.
  std::int64_t next_due(std::int64_t now);
  /// A datagram with this connection's receiver number. False if it was not opened.
  bool on_datagram(std::span<const std::byte> datagram, std::int64_t now) {
    if (!open(datagram, now)) return false;
    read(now);
    return true;
  }
  /// on_datagram() in two steps: the first authenticates the sender, the second applies the
  /// contents.
  bool open(std::span<const std::byte> datagram, std::int64_t now);
  void read(std::int64_t now);

  /// A sealed datagram of or for a third peer.
  struct Relayed {
    bool forward = false;  // whether it is for `peer`; else from there
    consensus::PeerId peer = 0;
    std::span<const std::byte> datagram;
  };
  /// To be sent at once; empty if this connection no longer sends. Valid until the next call.
  std::span<const std::byte> seal(const Relayed& relayed, std::int64_t now);
  /// From the last read(). Valid until the next open().
  std::optional<Relayed> take_relayed() { return std::exchange(relayed_, {}); }

  /// Ask the other end, on any path, to echo `token`, or echo its token. To be sent at once; empty
  /// if this connection no longer sends. Valid until the next call.
  std::span<const std::byte> seal_challenge(std::uint64_t token, std::int64_t now) {
    return seal_path(ChannelSection::Kind::Challenge, token, now);
  }
  std::span<const std::byte> seal_answer(std::uint64_t token, std::int64_t now) {
    return seal_path(ChannelSection::Kind::Answer, token, now);
  }
  static constexpr std::size_t kQuestionBytes = kProtectedOverhead + kChannelHeader + kPathBytes;
  /// Whether the packet opened and not read yet has the highest number so far.
  bool is_newest() const { return opened_ && opened_->sequence == opener_.window().latest(); }
  /// Number of the next packet to be sealed.
  std::uint64_t next_sequence() const { return sealer_.next_sequence(); }
  /// A new path: start the estimates over.
  void begin_path(std::int64_t now);

  /// Send goodbyes, then be Closed.
  void leave(const std::string& reason, std::int64_t now);

  State state() const { return state_; }
  /// Why it is leaving or closed.
  const std::string& reason() const { return reason_; }
  /// Whether a live packet has come that only the other end could have sealed.
  bool confirmed() const { return silence_.confirmed; }
  /// Whether it has been silent for so long that it may have gone.
  bool silent(std::int64_t now) const { return now - silence_.heard > options_.idle_timeout / 2; }
  std::int64_t last_heard() const { return silence_.heard; }
  const Session& session() const { return session_; }
  Channels& channels() { return channels_; }
  const Channels& channels() const { return channels_; }
  const Congestion& congestion() const { return rate_.congestion(); }
  const PacketOpener::Counters& opened() const { return opener_.counters(); }
  std::uint64_t rejected() const { return rejected_; }

 private:
  /// Silence of either end and its limits, ns.
  struct Silence {
    std::int64_t heard = 0;            ///< time of the last packet received
    std::int64_t sent = 0;             ///< time of the last packet sent
    std::int64_t patience = 0;         ///< longest silence of the other end before closing
    std::int64_t idle_keep_alive = 0;  ///< of a confirmed connection
    bool confirmed = false;
    /// Longest silence before a packet is sent.
    std::int64_t keep_alive() const {
      return confirmed ? idle_keep_alive : std::min(idle_keep_alive, kConfirmTime / 8);
    }
  };
  struct Goodbyes {
    int left = 0;  // still to be sent
    std::int64_t due = 0;
  };

  std::span<const std::byte> seal(std::int64_t now);
  std::span<const std::byte> seal_path(ChannelSection::Kind kind, std::uint64_t token,
                                       std::int64_t now);
  void close(const std::string& reason);
  bool may_send() const { return silence_.confirmed || began_here_; }
  std::size_t room() const { return channels_.mtu().size() - kProtectedOverhead; }

  Session session_;
  UdpConnectionOptions options_;
  PacketSealer sealer_;
  PacketOpener opener_;
  Channels channels_;
  SendRate rate_;
  ClockTurns clock_turns_;
  State state_ = State::Open;
  std::string reason_;
  bool began_here_;
  Goodbyes goodbyes_;
  Silence silence_;
  std::uint64_t rejected_ = 0;
  std::vector<std::byte> plain_;
  std::vector<std::byte> datagram_;
  std::vector<std::byte> buffer_;
  std::optional<PacketOpener::Opened> opened_;
  std::optional<Relayed> relayed_;
};

}  // namespace tandem::net
