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

/// The connections of a node, and which of them is a peer's: who is let in, which of two is kept,
/// what is kept of who has gone. Times in ns.
///
/// Two connections to one peer: one that is silent gives way; a larger incarnation wins; of one
/// process a direct one, then the one that the lower id began, then the newer one. Both ends decide
/// alike.
class UdpPeers {
 public:
  using PeerId = consensus::PeerId;

  struct Record;
  struct Connection {
    std::unique_ptr<UdpConnection> link;
    ConnectionPath path;
    bool began_here = false;
    std::int64_t opened = 0;
    Pacer relay;                   // what it may have passed on
    Record* record = nullptr;      // of its peer, while it is attached
    std::int64_t tell_due = 0;     // when it is told again who is there,
    PeerId told_to = 0;            // from whom on
    std::int64_t round_trip = -1;  // of the last exchange of clocks
  };
  struct Record {
    consensus::PeerStatus status;
    std::uint64_t incarnation = 0;
    Member member;                     // who goes by this id, or did last
    Connection* connection = nullptr;  // that is attached
    bool dropped = false;              // until it makes a handshake itself
    std::int64_t hold_until = INT64_MIN;
    std::vector<Channels::Message> inbox;        // of connections that are gone
    std::optional<Channels::Reliable> reliable;  // likewise, of this incarnation
    std::uint64_t departure = 0;  // of arrivals and departures, the later, the larger
    Seniority seniority;
  };
  using Connections = std::map<std::uint32_t, Connection>;  // by receiver number

  /// @param lost  told of each peer whose connection is attached no longer
  UdpPeers(const UdpNodeOptions& options, std::function<void(PeerId)> lost)
      : options_(options), lost_(std::move(lost)) {}

  Connections& connections() { return connections_; }
  const Connections& connections() const { return connections_; }
  /// Null where there is none.
  const Record* record(PeerId peer) const;
  Connection* attached(PeerId peer) const;
  /// Calls `use(peer)` with each that has a connection, by ascending id; it changes none.
  template <class Use>
  void for_each_attached(Use&& use) const {
    for (const auto& [peer, record] : records_) {
      if (record.connection != nullptr) use(peer);
    }
  }
  bool is_attached_directly(PeerId peer) const;
  /// A connection that was begun here to this address has not been heard of yet.
  bool is_asked(const Address& address) const;
  bool is_leaving() const { return leaving_; }

  Verdict decide(const Introduction& other, const Member& member, const Address& from,
                 std::int64_t now);
  Connection& add(const Session& session, const Address& address, bool began_here,
                  std::int64_t now);
  /// Makes it its peer's connection. False where it is to leave instead.
  bool attach(Connection& connection, std::int64_t now);
  void detach(Connection& connection);
  void drop(PeerId peer, const std::string& reason, std::int64_t now);
  /// Cut off whoever is no member any more.
  void expel(std::int64_t now);
  /// Say goodbye to all, and let nobody in.
  void leave(const std::string& reason, std::int64_t now);
  /// A handshake with it has failed.
  void note_failure(PeerId peer, const std::string& reason);

  bool post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
            std::int64_t now);
  void drain(const ClockSync& clock, std::vector<consensus::Packet>& out);
  /// In place of what is there.
  void list(std::vector<consensus::PeerStatus>& out) const;

  /// Something reliable is still on its way.
  bool busy() const;
  /// Whom to speak to from socket to socket, by ascending id, and how many are; for nodes with
  /// UdpNodeOptions::direct_addresses.
  void prefer_direct(std::span<const PeerId> peers, std::int64_t now);
  std::size_t direct();

  /// Tell all others where the other end of a connection is.
  void tell_others(const Connection& connection);
  /// Tell the other end where some of the others are, in turn, where it is time to.
  void introduce(Connection& connection, std::int64_t now);

 private:
  std::size_t attached_count() const;
  /// See who_gives_way().
  Record* guest_in_place_of(PeerId peer, const Member& member);
  /// Whether an id that is not bound is somebody else's for now.
  static bool is_taken(const Record& record, const Member& member, std::int64_t now);
  /// Make room for one more by somebody else.
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
