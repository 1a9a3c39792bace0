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

/// What is in a sealed packet, its first byte.
enum class Channel : std::uint8_t {
  Newest = 0,    ///< of the sharing, may be lost
  Reliable = 1,  ///< of the sharing
  Words = 2,     ///< JSON: who is away, what was made, how to meet directly
  Digest = 3,    ///< where the sender's bodies are, to be compared
  Hand = 4,      ///< where the sender's hand is: f32 anchor and attachment, and the body's name.
                 ///< Pages in headsets say head and hands (tools/room/README.md)
};

/// Members of a room as a transport between peers, by way of the room's server.
/// @par Thread safety  One object: one thread at a time.
class RoomTransport final : public consensus::Transport {
 public:
  /// A member's own words.
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

  /// Takes in what has come; before each step.
  void poll();
  bool send(MemberId to, Channel channel, std::span<const std::uint8_t> bytes);
  /// Words and digests since the last call, appended.
  void take(std::vector<Heard>& out);
  /// Who has come since the last call, appended.
  void take_newcomers(std::vector<MemberId>& out);
  /// A member is there and takes no part.
  void set_away(MemberId id, bool away);
  /// Session time, ns, as the server has it; nullopt before the server has said so.
  std::optional<consensus::SessionTime> now() const;
  bool connected() const { return link_.connected(); }
  std::size_t members() const;
  std::uint64_t refused() const { return refused_; }

 private:
  struct Member {
    bool here = false;
    bool away = false;
    bool dropped = false;  ///< what it sends cannot be understood
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
