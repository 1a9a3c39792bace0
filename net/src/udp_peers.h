// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clock_sync.h"
#include "connection_path.h"
#include "handshake.h"
#include "pacing.h"
#include "places.h"
#include "tandem/consensus/transport.h"
#include "udp_connection.h"
#include "udp_node_options.h"

namespace tandem::net {

/// The connections of a node and their peers: admission, which of two connections is kept, and what
/// is kept of departed peers. Times in ns.
///
/// Of two connections to one peer, a silent one gives way; a larger incarnation wins; within one
/// process a direct one wins, then the one begun by the lower id, then the newer one. Both ends
/// decide alike.
class UdpPeers {
 public:
  using PeerId = consensus::PeerId;

  struct Record;
  struct Connection {
    std::unique_ptr<UdpConnection> link;
    ConnectionPath path;
    bool began_here = false;
    std::int64_t opened = 0;
    Pacer relay;                   // budget for relaying
    Record* record = nullptr;      // of its peer, while attached
    std::int64_t tell_due = 0;     // when to announce other peers to it again
    PeerId told_to = 0;            // id of the last peer announced
    std::int64_t round_trip = -1;  // of the last clock exchange
  };
  struct Record {
    consensus::PeerStatus status;
    std::uint64_t incarnation = 0;
    Member member;                     // present or last user of this id
    Connection* connection = nullptr;  // the attached one
    bool dropped = false;              // until its next own handshake
    std::int64_t hold_until = INT64_MIN;
    std::vector<Channels::Message> inbox;        // of closed connections
    std::optional<Channels::Reliable> reliable;  // of closed connections, of this incarnation
    std::uint64_t departure = 0;                 // order of arrivals and departures, increasing
    Seniority seniority;
  };
  using Connections = std::map<std::uint32_t, Connection>;  // by receiver number

  /// @param lost  called for each peer whose connection was detached
  UdpPeers(const UdpNodeOptions& options, std::function<void(PeerId)> lost)
      : options_(options), lost_(std::move(lost)) {}

  Connections& connections() { return connections_; }
  const Connections& connections() const { return connections_; }
  /// Null if there is none.
  const Record* record(PeerId peer) const;
  Connection* attached(PeerId peer) const;
  /// Calls `use(peer)` for each peer with a connection, by ascending id; it must not change any.
  template <class Use>
  void for_each_attached(Use&& use) const {
    for (const auto& [peer, record] : records_) {
      if (record.connection != nullptr) use(peer);
    }
  }
  bool is_attached_directly(PeerId peer) const;
  /// Whether a connection begun here to this address is unconfirmed.
  bool is_asked(const Address& address) const;
  bool is_leaving() const { return leaving_; }

  Verdict decide(const Introduction& other, const Member& member, const Address& from,
                 std::int64_t now);
  Connection& add(const Session& session, const Address& address, bool began_here,
                  std::int64_t now);
  /// Attaches it to its peer. False if it is to leave instead.
  bool attach(Connection& connection, std::int64_t now);
  void detach(Connection& connection);
  void drop(PeerId peer, const std::string& reason, std::int64_t now);
  /// Disconnect peers that are no longer members.
  void expel(std::int64_t now);
  /// Say goodbye to all, and admit nobody.
  void leave(const std::string& reason, std::int64_t now);
  /// A handshake with the peer has failed.
  void note_failure(PeerId peer, const std::string& reason);

  bool post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
            std::int64_t now);
  void drain(const ClockSync& clock, std::vector<consensus::Packet>& out);
  /// Replaces the contents of `out`.
  void list(std::vector<consensus::PeerStatus>& out) const;

  /// Whether a reliable message is still undelivered.
  bool busy() const;
  /// Peers to address from socket to socket, by ascending id; and how many are. For nodes with
  /// UdpNodeOptions::direct_addresses.
  void prefer_direct(std::span<const PeerId> peers, std::int64_t now);
  std::size_t direct();

  /// Announce the other end of a connection to all others.
  void tell_others(const Connection& connection);
  /// Announce some of the others to it, in turn, when due.
  void introduce(Connection& connection, std::int64_t now);

 private:
  std::size_t attached_count() const;
  /// See who_gives_way().
  Record* guest_in_place_of(PeerId peer, const Member& member);
  /// Whether an unbound id is in use by another key.
  static bool is_taken(const Record& record, const Member& member, std::int64_t now);
  /// Make room for one more connection begun by another peer.
  void forget_unconfirmed(const crypto::PublicKey& key);
  void forget_departed();
  void shed_departed();

  const UdpNodeOptions& options_;
  std::function<void(PeerId)> lost_;
  Connections connections_;
  std::map<PeerId, Record> records_;
  std::uint64_t events_ = 0;  // arrivals and departures
  bool leaving_ = false;
};

}  // namespace tandem::net
