// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquaintances.h"
#include "address.h"
#include "clock_sync.h"
#include "handshake.h"
#include "path_validation.h"
#include "tandem/consensus/transport.h"
#include "udp_connection.h"

namespace tandem::net {

struct UdpNodeOptions {
  HandshakeConfig handshake;
  UdpConnectionOptions connection;
  std::size_t max_peers = 64;
  std::int64_t backoff_min = 100'000'000;
  std::int64_t backoff_max = 3'000'000'000;
  std::int64_t drop_hold = 1'000'000'000;
  bool relay = true;  ///< for others, and by others
  /// Members tell each other of third ones and dial whom they are told of; false: whoever drives
  /// the node says whom to meet.
  bool introduces = true;
  double relay_kbit = 256.0;  ///< from each peer, for others
  Clock clock = Clock::Session;
  /// DatagramPath::max_datagram() of the path with this number; empty: what fits into another one.
  std::function<std::size_t(std::uint64_t path)> path_limit;
  std::int64_t start = 0;       // the time at construction
  std::int64_t correction = 0;  // session time minus that, to begin with
};

/// One process of a mesh without its socket: handshakes, connections, who is who. Datagrams come
/// in, datagrams go out by `send`; nothing waits, nothing reads a clock. Times in ns.
///
/// Two connections to one peer: one that is silent gives way; a larger incarnation wins; of one
/// process a direct one, then the one that the lower id began, then the newer one. Both ends decide
/// alike.
///
/// Connected peers tell each other where the third ones are, so that one address is enough to meet
/// all. Who cannot be reached for kRelayPatience is asked through one that can; a connection made
/// that way has keys of its own, which the relay does not have.
class UdpNode {
 public:
  using Send = std::function<void(std::span<const std::byte>, const Address&)>;

  UdpNode(const UdpNodeOptions& options, const crypto::Random& random, Send send);
  UdpNode(const UdpNode&) = delete;
  UdpNode& operator=(const UdpNode&) = delete;

  /// Keep trying to have a connection to whoever is there.
  void dial(const Address& address, std::int64_t now);
  /// Dial no more by this path, and end what goes over it.
  void hang_up(std::uint64_t path, const std::string& reason, std::int64_t now);
  /// False where it was of no use to anybody.
  bool on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  /// The same of what came by the DatagramPath with this number. What is sent to path_address() of
  /// it is to go there.
  bool on_path(std::span<const std::byte> datagram, std::uint64_t number, std::int64_t now) {
    now_ = now;
    return receive(datagram, path_address(number), now);
  }
  /// Sends what is due; call at next_due() and after anything else.
  void poll(std::int64_t now);
  std::int64_t next_due(std::int64_t now);
  /// Say goodbye to all; no new connections. Done when connections() is 0.
  void leave(const std::string& reason, std::int64_t now);
  std::size_t connections() const { return connections_.size(); }
  /// Something reliable is still on its way.
  bool busy() const;

  bool post(consensus::PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
            std::int64_t now);
  void drain(std::vector<consensus::Packet>& out);
  void drop(consensus::PeerId peer, const std::string& reason, std::int64_t now);
  std::vector<consensus::PeerStatus> peers() const;

  /// Bytes of the longest state that post() takes to any peer, as far as is known of the ways
  /// there.
  std::size_t max_state_bytes() const;
  /// Where the system would send what is too long in pieces. Before any connection.
  void keep_to_base() {
    options_.connection.max_datagram = std::min(options_.connection.max_datagram, MtuSearch::kBase);
  }

  /// Take over what the organiser has signed and pass it on: whoever is revoked is told so and cut
  /// off at once.
  Credentials::Changed change_group(std::span<const std::byte> signed_change, std::int64_t now);
  /// Who this is and whom it lets in, with all that the organiser has said since.
  const Credentials& credentials() const { return options_.handshake; }
  /// Number of the change that holds; 0: none.
  std::uint64_t group() const { return options_.handshake.group; }

  /// As if the connected peer `teller` had said so.
  void told(consensus::PeerId teller, const KnownPeer& known, std::int64_t now) {
    if (Connection* connection = attached(teller)) on_told(*connection, known, now);
  }
  /// As if the connected peer `relay` had passed this on as from `from`.
  void passed_on(consensus::PeerId relay, consensus::PeerId from,
                 std::span<const std::byte> datagram, std::int64_t now) {
    Connection* connection = attached(relay);
    if (connection == nullptr) return;
    now_ = now;
    on_relayed(*connection, {.forward = false, .peer = from, .datagram = datagram}, now);
  }
  struct Relayed {
    std::uint64_t forwarded = 0;  // datagrams for others
    std::uint64_t refused = 0;    // no way there, over the rate, or not wanted
  };
  const Relayed& relayed() const { return relayed_; }
  /// Through whom packets to `peer` go; 0: straight there, or nowhere.
  consensus::PeerId relay_of(consensus::PeerId peer) const;
  /// The upper half of all receiver numbers that this node gives out.
  std::uint16_t receiver_prefix() const { return receiver_prefix_; }

  SessionTime session_now(std::int64_t now) { return clock_.now(now); }
  ClockStatus clock(std::int64_t now);
  /// With Clock::System: what that is ahead.
  void set_correction(std::int64_t correction, std::int64_t now) {
    clock_.set_correction(correction, now);
  }
  const HandshakeResponder::Counters& strangers() const { return responder_.counters(); }
  /// Datagrams with a receiver number that nobody has, or from another address than its peer's that
  /// it has not sealed.
  std::uint64_t unknown() const { return unknown_; }
  /// How often a peer was followed to another address.
  std::uint64_t moves() const { return moves_; }

 private:
  struct Dial {
    Address address;
    consensus::PeerId peer = 0;  // 0 until it has told
    std::unique_ptr<HandshakeInitiator> attempt;
    std::int64_t due = 0;
    std::int64_t backoff = 0;
    std::size_t attempts = 0;
    consensus::PeerId told_by = 0;  // 0: by the application
    std::int64_t told_at = 0;
  };
  struct Connection {
    std::unique_ptr<UdpConnection> link;
    Address address;
    bool began_here = false;
    std::int64_t opened = 0;
    bool attached = false;
    Pacer relay;                            // what it may have passed on
    std::int64_t tell_due = 0;              // when it is told again who is there,
    consensus::PeerId told_to = 0;          // from whom on
    std::int64_t round_trip = -1;           // of the last exchange of clocks
    std::optional<PathValidation> moving;   // packets come from another address
    std::optional<PathRumour> rumour;       // others say that it is elsewhere
    std::int64_t question_due = INT64_MIN;  // who copies packets does not make us ask all the time
  };
  struct Record {
    consensus::PeerStatus status;
    std::uint64_t incarnation = 0;
    Member member;               // who goes by this id, or did last
    std::uint32_t receiver = 0;  // of the attached connection; 0: none
    bool dropped = false;        // until it makes a handshake itself
    std::int64_t hold_until = INT64_MIN;
    std::vector<Channels::Message> inbox;        // of connections that are gone
    std::optional<Channels::Reliable> reliable;  // likewise, of this incarnation
    std::uint64_t departure = 0;                 // the later, the larger
  };

  bool receive(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  bool on_packet(const ProtectedHeader& header, std::span<const std::byte> datagram,
                 const Address& from, std::int64_t now);
  void transmit(std::span<const std::byte> datagram, const Address& to);
  static bool may_move(const Connection& connection, const Address& to);
  /// A packet of the other end has come from another address than before.
  void note_path(Connection& connection, std::uint64_t sequence, const Address& from,
                 std::size_t bytes, std::int64_t now);
  /// What the packet from there asks about its way, or answers.
  void answer_path(Connection& connection, const Address& from, std::int64_t now);
  void note_rumour(Connection& connection, const Address& to, std::int64_t now);
  void poll_path(Connection& connection, std::int64_t now);
  void poll_rumour(Connection& connection, std::int64_t now);
  /// When poll_path() may do something, if nothing comes before.
  static std::int64_t path_due(const Connection& connection, std::int64_t now);
  void move(Connection& connection, std::int64_t now);
  std::uint64_t random_token() const;
  /// Where this peer is, to all others.
  void tell_others(const Connection& connection);
  void on_relayed(Connection& connection, const UdpConnection::Relayed& relayed, std::int64_t now);
  void on_told(Connection& connection, const KnownPeer& known, std::int64_t now);
  void introduce(Connection& connection, std::int64_t now);
  void look_for_relays(std::int64_t now);
  void forget_dials(std::int64_t now);
  void shed_departed();
  /// Make room for one more of them where there is none.
  void forget_unconfirmed();
  void forget_departed();
  bool is_attached_directly(consensus::PeerId peer) const;
  std::size_t attached_count() const;
  Verdict decide(const Introduction& other, const Member& member, const Address& from,
                 std::int64_t now) const;
  /// Whether an id that is not bound is somebody else's for now.
  bool is_taken(const Record& record, const Member& member, std::int64_t now) const;
  void on_group_change(Connection& connection, std::span<const std::byte> change, std::int64_t now);
  /// Cut off whoever is no member any more.
  void expel(std::int64_t now);
  std::uint32_t free_receiver();
  void open(const Session& session, const Address& address, bool began_here, std::int64_t now);
  void attach(std::uint32_t receiver, std::int64_t now);
  void detach(Connection& connection);
  bool is_wanted(const Dial& dial) const;
  void poll_dial(Dial& dial, std::int64_t now);
  void finish(Dial& dial, std::int64_t now);
  Connection* attached(consensus::PeerId peer);

  UdpNodeOptions options_;
  crypto::Random random_;
  Send send_;
  std::int64_t now_ = 0;  // of the call that is running
  ClockSync clock_;
  std::int64_t clock_due_ = INT64_MIN;
  HandshakeResponder responder_;
  std::vector<Dial> dials_;
  std::map<std::uint32_t, Connection> connections_;
  std::map<consensus::PeerId, Record> records_;
  Acquaintances acquaintances_;
  std::int64_t mesh_due_ = INT64_MIN;
  Relayed relayed_;
  std::uint64_t departures_ = 0;
  std::uint16_t receiver_prefix_ = 0;
  std::uint64_t unknown_ = 0;
  std::uint64_t moves_ = 0;
  bool leaving_ = false;
};

}  // namespace tandem::net
