// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "common/ranges.h"
#include "members/index_tables.h"
#include "tandem/consensus/peer.h"

namespace tandem::consensus {

/// Bytes of the longest packet that decode() and the transport accept.
inline std::size_t packet_limit(const Transport& transport, Delivery delivery) {
  return std::min(kMaxPacketBytes, transport.max_packet_bytes(delivery));
}

/// Who is connected, and packets to them.
class Connections {
 public:
  static constexpr PeerId kToAll = 0;

  Connections(Transport& transport, PeerStats& stats) : transport_(transport), stats_(stats) {}

  /// Ask the transport who is connected.
  void refresh() {
    transport_.list_peers(peers_);
    std::erase_if(newcomers_, [this](PeerId id) {
      return !ranges::any_of(
          peers_, [id](const PeerStatus& peer) { return peer.id == id && peer.connected; });
    });
    // A peer that reconnects sends its indices again.
    std::erase_if(connected_, [this](PeerId id) {
      const auto at = ranges::lower_bound(peers_, id, &PeerStatus::id);
      if (at != peers_.end() && at->id == id && at->connected) return false;
      indices_.forget(id);
      return true;
    });
    for (const PeerStatus& peer : peers_) {
      const auto at = std::lower_bound(connected_.begin(), connected_.end(), peer.id);
      const bool known = at != connected_.end() && *at == peer.id;
      if (peer.connected && !known) {
        // Peers present before the first states were sent receive those.
        if (has_sent_) newcomers_.push_back(peer.id);
        connected_.insert(at, peer.id);
      }
    }
  }
  /// All peers known to the transport, by id, as of the last refresh().
  std::span<const PeerStatus> peers() const { return peers_; }
  /// Those connected, ascending.
  std::span<const PeerId> connected() const { return connected_; }
  /// Those that connected after the first states had been sent, and need the full state.
  std::span<const PeerId> newcomers() const { return newcomers_; }
  /// The newcomers have been sent the full state.
  void greeted() { newcomers_.clear(), has_sent_ = true; }

  /// The other peers' indices of bodies; kept for those connected.
  IndexTables& indices() { return indices_; }

  /// Encode one message and post it; to all peers if `to` is kToAll.
  template <class Message>
  void post(PeerId to, const Message& message, Delivery delivery) {
    packet_.clear();
    encode(message, packet_);
    post_packet(to, delivery);
  }
  /// Post any number of records, in packets that the transport accepts.
  /// @return bytes of all packets, with `overhead` for each
  template <class Record>
  double post_records(PeerId to, std::span<const Record> records, std::size_t record_bytes,
                      Delivery delivery, double overhead = 0.0) {
    const std::size_t packet = packet_limit(transport_, delivery);
    const std::size_t most = std::min(kMaxRecords, records_in(packet, record_bytes));
    double bytes = 0.0;
    while (!records.empty()) {
      const std::size_t count = std::min(most, records.size());
      packet_.clear();
      encode(records.first(count), packet_);
      bytes += static_cast<double>(packet_.size()) + overhead;
      post_packet(to, delivery);
      records = records.subspan(count);
    }
    return bytes;
  }

 private:
  void post_packet(PeerId to, Delivery delivery) {
    if (to == kToAll && packet_.empty()) return;
    const std::span<const PeerId> receivers = to == kToAll ? connected() : std::span(&to, 1);
    for (const PeerId peer : receivers) {
      if (transport_.post(peer, packet_, delivery)) stats_.bytes_sent += packet_.size();
    }
  }

  Transport& transport_;
  PeerStats& stats_;
  std::vector<PeerStatus> peers_;
  std::vector<PeerId> connected_;
  std::vector<PeerId> newcomers_;
  bool has_sent_ = false;
  IndexTables indices_;
  std::vector<std::byte> packet_;
};

}  // namespace tandem::consensus
