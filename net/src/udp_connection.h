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
  /// The most that is tried, in [548, kMaxDatagram]; 548 for an MTU of 576.
  std::size_t max_datagram = kMaxDatagram;
  std::int64_t idle_timeout = 5'000'000'000;
};

/// One connection after its handshake: datagrams in, datagrams out, messages for the application.
/// No socket and no clock; times are ns of any clock that does not go back.
class UdpConnection {
 public:
  enum class State { Open, Leaving, Closed };

  /// @param began_here  else nothing is sent before the other end is confirmed: its address would
  ///   get more than came from there
  UdpConnection(const Session& session, const UdpConnectionOptions& options, bool began_here,
                std::int64_t now);
  /// Whoever has answered a handshake answers under its keys in this time, or has forgotten it, ns.
  static constexpr std::int64_t kConfirmTime = 2'000'000'000;

  /// False where it is dropped at once: closed, too long, queue of reliable messages full.
  bool post(std::span<const std::byte> bytes, consensus::Delivery delivery, std::int64_t now);

  /// The next datagram to send, empty where none is due yet. Valid until the next call. Call until
  /// it is empty. @param clock  what to say of the own clock at `now`; null: nothing, ever
  std::span<const std::byte> poll(std::int64_t now, const ClockClaim* clock = nullptr);
  /// When poll() will have something, if nothing comes or is posted before.
  std::int64_t next_due(std::int64_t now);
  /// A datagram with this connection's receiver number. False where it was not opened.
  bool on_datagram(std::span<const std::byte> datagram, std::int64_t now) {
    if (!open(datagram, now)) return false;
    read(now);
    return true;
  }
  /// The same in two steps: who has sealed it is known after the first, what is in it counts with
  /// the second.
  bool open(std::span<const std::byte> datagram, std::int64_t now);
  void read(std::int64_t now);

  /// A datagram of or for a third peer, sealed and not looked into.
  struct Relayed {
    bool forward = false;  // it is for `peer`; else it is from there
    consensus::PeerId peer = 0;
    std::span<const std::byte> datagram;
  };
  /// To be sent at once; empty where this connection does not send any more. Valid until the next
  /// call.
  std::span<const std::byte> seal(const Relayed& relayed, std::int64_t now);
  /// What the last read() has found. Valid until the next open().
  std::optional<Relayed> take_relayed() { return std::exchange(relayed_, {}); }

  /// Ask the other end, on some way to it, to say `token` again, or say what it has asked for. To
  /// be sent at once; empty where this connection does not send any more. Valid until the next
  /// call.
  std::span<const std::byte> seal_challenge(std::uint64_t token, std::int64_t now) {
    return seal_path(ChannelSection::Kind::Challenge, token, now);
  }
  std::span<const std::byte> seal_answer(std::uint64_t token, std::int64_t now) {
    return seal_path(ChannelSection::Kind::Answer, token, now);
  }
  static constexpr std::size_t kQuestionBytes = kProtectedOverhead + kChannelHeader + kPathBytes;
  /// The packet that was opened and not read yet has the highest number so far.
  bool is_newest() const { return opened_ && opened_->sequence == opener_.window().latest(); }
  /// Of the next packet that is sealed.
  std::uint64_t next_sequence() const { return sealer_.next_sequence(); }
  /// It goes another way from now on: what was learned of the one before does not hold.
  void begin_path(std::int64_t now);

  /// Say goodbye, then be Closed.
  void leave(const std::string& reason, std::int64_t now);

  State state() const { return state_; }
  /// Why it is leaving or closed.
  const std::string& reason() const { return reason_; }
  /// A packet has come that only the other end could have sealed, now.
  bool confirmed() const { return silence_.confirmed; }
  /// Nothing has come for so long that it may have gone.
  bool silent(std::int64_t now) const { return now - silence_.heard > options_.idle_timeout / 2; }
  std::int64_t last_heard() const { return silence_.heard; }
  const Session& session() const { return session_; }
  Channels& channels() { return channels_; }
  const Channels& channels() const { return channels_; }
  const Congestion& congestion() const { return rate_.congestion(); }
  const PacketOpener::Counters& opened() const { return opener_.counters(); }
  std::uint64_t rejected() const { return rejected_; }

 private:
  /// How long either end has been silent and may be, ns.
  struct Silence {
    std::int64_t heard = 0;            ///< when, last
    std::int64_t sent = 0;             ///< likewise
    std::int64_t patience = 0;         ///< nothing heard for so long: it is closed
    std::int64_t idle_keep_alive = 0;  ///< of a confirmed connection
    bool confirmed = false;
    /// Nothing sent for so long: something is.
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
