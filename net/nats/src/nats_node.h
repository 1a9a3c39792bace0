// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cell_wire.h"
#include "group_seal.h"
#include "hub_impl.h"
#include "inbox.h"
#include "load.h"
#include "nearest.h"
#include "neighbourhood.h"
#include "speaker.h"
#include "subjects.h"
#include "tandem/nats/nats_transport.h"
#include "udp_node.h"

namespace tandem::nats {

/// One peer of NatsTransport without its lock: a node whose datagrams go to subjects, and its
/// messages to and from cells. Times in ns, of the transport's clock.
class NatsNode {
 public:
  NatsNode(const NatsOptions& options, std::shared_ptr<NatsHub> hub, std::int64_t now,
           std::int64_t correction, std::function<std::int64_t()> steady);
  NatsNode(const NatsNode&) = delete;
  NatsNode& operator=(const NatsNode&) = delete;

  /// Process received messages, and do due work.
  void tick(std::int64_t now);

  net::UdpNode& node() { return node_; }
  void move(const pbd::Vec3& position) { hood_.move(position); }
  void near_peers(std::vector<NearPeer>& out) const {
    const auto met = hood_.met_peers();
    out.insert(out.end(), met.begin(), met.end());
  }
  bool speaks(int level, std::int64_t now) const;
  bool set_summary(int level, std::span<const std::byte> content);
  void drain(std::vector<consensus::Packet>& out);
  void take_summaries(std::vector<CellSummary>& out);
  NatsStatus status();

 private:
  using PeerId = consensus::PeerId;

  struct Level {
    explicit Level(PeerId self, std::int64_t now) : speaker(self, now) {}
    Speaker speaker;
    std::vector<std::byte> content;
    /// Summaries of all parts of its cell, while it summarises that.
    NatsOwned<natsSubscription> within;
    Cell of_within{-1, 0, 0};
    std::map<Cell, std::pair<std::uint32_t, std::int64_t>> people;  ///< in its parts, and when
                                                                    ///< heard
  };

  /// Messages sealed for the group, and opened.
  struct Seal {
    GroupSealer sealer;
    GroupOpener opener;
    std::uint64_t group = 0;        ///< last change applied
    std::uint64_t unbelieved = 0;   ///< opened, but not accepted
    std::vector<std::byte> plain;   ///< scratch
    std::vector<std::byte> sealed;  ///< scratch
  };
  /// Keys for signing summaries.
  struct Speaking {
    std::optional<net::crypto::Secret> secret;  ///< own
    std::map<PeerId, net::crypto::PublicKey> trusted;
  };
  /// Near peers by UDP.
  struct Direct {
    Nearest nearest;
    std::shared_ptr<DirectSocket::Hear> hear;
    /// Separate, so that a flood of the socket takes no room from the server's messages.
    std::shared_ptr<Inbox> inbox = std::make_shared<Inbox>();
    std::uint64_t out = 0;
    std::uint64_t bytes_out = 0;
    std::uint64_t in = 0;
    std::uint64_t bytes_in = 0;
  };
  struct Clocks {
    std::function<std::int64_t()> steady;
    std::int64_t correction = 0;    ///< ns: system clock at the start minus own clock
    std::int64_t last = INT64_MIN;  ///< latest time given to the node
  };
  struct Due {
    std::int64_t follow = INT64_MIN;
    std::int64_t presence = INT64_MIN;
  };

  void send(std::span<const std::byte> datagram, const net::Address& to);
  void take_in(const Inbox::Message& message);
  void listen_directly();
  void on_datagram(const Inbox::Message& message);
  void on_direct(const Inbox::Message& message);
  GroupOpener::Opened open(const Inbox::Message& message);
  void on_presence(const Inbox::Message& message);
  void on_summary(const Inbox::Message& message);
  bool is_believed(PeerId sender, const Summary& summary, std::span<const std::byte> plain) const;
  void follow(std::int64_t now);
  /// Request a connection from a member that may be present but whose messages were not accepted.
  void invite(PeerId peer, std::size_t key);
  /// Unconnected peers must confirm a new session key.
  void heed_group_change(std::int64_t now);
  /// Make the node's connections those that the neighbourhood wants.
  void reconcile(std::int64_t now);
  void say_where(std::int64_t now);
  void speak(std::int64_t now);
  void listen_within(Level& level, int number, std::int64_t now);
  std::uint32_t people_of(Level& level, const Cell& cell, std::int64_t now);
  NatsOwned<natsSubscription> subscribe(const std::string& subject, Inbox::Kind kind);
  void publish_sealed(const std::string& subject, std::span<const std::byte> plain);

  CellOptions cells_;
  PeerId self_;
  Subjects subjects_;
  std::shared_ptr<NatsHub> hub_;
  Clocks clocks_;
  Speaking speaking_;

  std::shared_ptr<Inbox> inbox_ = std::make_shared<Inbox>();
  net::UdpNode node_;
  Neighbourhood hood_;
  Load load_;
  Direct direct_;
  std::vector<Level> levels_;  ///< from level 1 on
  Seal seal_;
  NatsOwned<natsSubscription> own_;
  std::map<Cell, NatsOwned<natsSubscription>> heard_cells_;

  Due due_;
  std::map<PeerId, std::int64_t> amiss_;    ///< peers whose connection is not as wanted, since when
  std::map<PeerId, std::int64_t> invited_;  ///< time of invitation
  std::vector<consensus::Packet> packets_;  ///< of summaries
  std::vector<CellSummary> summaries_;
};

}  // namespace tandem::nats
