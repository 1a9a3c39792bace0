// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cipher/cipher.h"
#include "peer/link.h"
#include "tandem/consensus/transport.h"

namespace tandem::room {

/// First byte of a sealed packet.
enum class Channel : std::uint8_t {
  Newest = 0,    ///< sharing, may be lost
  Reliable = 1,  ///< sharing
  Words = 2,     ///< JSON: absence, made bodies, signalling for direct connections
  Digest = 3,    ///< positions of the sender's bodies, for comparison
  Hand = 4,      ///< the sender's hand: f32 anchor and attachment, body's name; for headsets see
                 ///< tools/room/README.md
};

/// Members of a room as a transport between peers, through the room's server.
/// @par Thread safety  One object: one thread at a time.
class RoomTransport final : public consensus::Transport {
 public:
  struct Heard {
    MemberId from = 0;
    Channel channel = Channel::Words;
    Bytes bytes;
  };

  /// @param profile  JSON: name and colour
  RoomTransport(const Address& address, MemberId self, std::string profile);

  // consensus::Transport
  consensus::PeerId self() const override { return self_; }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override;
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;

  /// Processes received messages; call before each step.
  void poll();
  bool send(MemberId to, Channel channel, std::span<const std::uint8_t> bytes);
  /// Appends words and digests since the last call.
  void take(std::vector<Heard>& out);
  /// Appends newcomers since the last call.
  void take_newcomers(std::vector<MemberId>& out);
  /// A member is present without taking part.
  void set_away(MemberId id, bool away);
  /// Session time of the server, ns; nullopt before its first answer.
  std::optional<consensus::SessionTime> now() const;
  bool connected() const { return link_.connected(); }
  std::size_t members() const;
  std::uint64_t refused() const { return refused_; }

 private:
  struct Member {
    bool here = false;
    bool away = false;
    bool dropped = false;  ///< sends invalid messages
    std::string reason;
  };

  void hear(const Bytes& message);
  void open(MemberId from, View sealed);
  void greet(MemberId to);
  void take_time(std::span<const std::uint8_t> bytes);

  MemberId self_;
  std::string profile_;
  Cipher cipher_;
  Link link_;
  std::map<MemberId, Member> members_;
  std::vector<consensus::Packet> packets_;
  std::vector<Heard> heard_;
  std::vector<MemberId> newcomers_;
  std::vector<Bytes> taken_;
  Bytes plain_;
  Bytes sealed_;
  std::optional<std::int64_t> offset_;  ///< ns, of the steady clock
  std::int64_t best_round_trip_ = INT64_MAX;
  std::int64_t asked_ = INT64_MIN;  ///< ns, steady clock
  int questions_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace tandem::room
