// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "cell_wire.h"
#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"
#include "tandem/nats/nats_transport.h"

namespace tandem::nats {

/// Decides which peers to connect to and which cells to subscribe to as the user moves. It is told
/// positions and returns changes; it does nothing itself. Times in ns.
///
/// Two peers are connected if each is within what the other one hears, and stay so until they are
/// `slack` beyond that: both ends decide by the same numbers. A peer hears up to `near`, or less if
/// more peers than its limit are there; the limit is max_near, and decreases to min_near while this
/// peer is too slow.
class Neighbourhood {
 public:
  using PeerId = consensus::PeerId;

  static constexpr std::size_t kMaxContacts = 1024;       ///< a nearer one replaces the farthest
  static constexpr std::int64_t kForget = 4'000'000'000;  ///< after this silence a peer is dropped

  Neighbourhood(const CellOptions& options, PeerId self) : options_(options), self_(self) {}

  /// Position of the user, m, world.
  void move(const pbd::Vec3& position) { position_ = position; }
  const pbd::Vec3& position() const { return position_; }
  void hear(PeerId peer, const Presence& presence, std::int64_t now);
  /// Its connection has ended: it is met again when it is heard again.
  void lose(PeerId peer) {
    contacts_.erase(peer);
    std::erase_if(met_, [peer](const NearPeer& each) { return each.peer == peer; });
  }
  /// Treat the peers named by `doubted` as silent since `then`.
  template <class Doubted>
  void doubt(const Doubted& doubted, std::int64_t then) {
    for (auto& [peer, contact] : contacts_) {
      if (doubted(peer)) contact.heard = std::min(contact.heard, then);
    }
  }
  bool is_met(PeerId peer) const {
    const auto at = contacts_.find(peer);
    return at != contacts_.end() && at->second.met;
  }
  /// This peer is too slow: fewer peers from now on. Or it keeps up: one more.
  void lower_limit();
  void raise_limit();
  std::size_t limit() const { return limit_; }

  struct Changes {
    std::vector<Cell> listen;  ///< of level 0: who is there; above: summaries
    std::vector<Cell> unlisten;
    std::vector<PeerId> meet;
    std::vector<PeerId> part;

    bool empty() const {
      return listen.empty() && unlisten.empty() && meet.empty() && part.empty();
    }
  };
  /// Changes to make now. Valid until the next call. @param served  whether there is a server;
  /// without one nobody is heard, and silence means nothing
  const Changes& update(bool served, std::int64_t now);

  /// m: how far this peer hears.
  double hears() const { return hears_; }
  std::size_t contacts() const { return contacts_.size(); }
  std::size_t met() const { return met_.size(); }
  /// By ascending id, as of the last update().
  std::span<const NearPeer> met_peers() const { return met_; }
  /// Peers in a cell, as far as known here.
  std::size_t people_in(const Cell& cell) const;
  bool listens_to(const Cell& cell) const { return cells_.contains(cell); }
  std::size_t cells() const { return cells_.size(); }

 private:
  struct Contact {
    pbd::Vec3 position = pbd::Vec3::Zero();
    double hears = 0.0;
    std::int64_t heard = 0;
    bool met = false;
  };

  double distance(const Contact& contact) const {
    return (contact.position - position_).head<2>().norm();
  }
  void update_hears();
  void update_peers(bool served, std::int64_t now);
  void update_cells();
  void want_around(int level, double radius);

  CellOptions options_;
  PeerId self_;
  pbd::Vec3 position_ = pbd::Vec3::Zero();
  std::size_t limit_ = options_.max_near;
  double hears_ = options_.near;
  std::map<PeerId, Contact> contacts_;
  std::vector<NearPeer> met_;
  std::set<Cell> cells_;
  std::optional<pbd::Vec3> cells_about_;  ///< position of the user when they were chosen
  Changes changes_;
  std::vector<double> distances_;  ///< scratch
};

}  // namespace tandem::nats
