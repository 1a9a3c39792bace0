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

/// Whom a peer is connected to and which cells it listens to, as its user walks. It is told of who
/// is where and says what is to change; it does nothing itself. Times in ns.
///
/// Two peers are connected where each is within what the other one hears, and stay so until they
/// are `slack` beyond that: both ends decide by the same numbers. What a peer hears is `near`, or
/// less where more than its limit are there; the limit is max_near, and goes down to min_near while
/// this peer is too slow.
class Neighbourhood {
 public:
  using PeerId = consensus::PeerId;

  static constexpr std::size_t kMaxContacts = 1024;       ///< the farthest goes for a nearer one
  static constexpr std::int64_t kForget = 4'000'000'000;  ///< who has been silent for so long

  Neighbourhood(const CellOptions& options, PeerId self) : options_(options), self_(self) {}

  /// The user is here now, m, world.
  void move(const pbd::Vec3& position) { position_ = position; }
  const pbd::Vec3& position() const { return position_; }
  void hear(PeerId peer, const Presence& presence, std::int64_t now);
  /// There is no connection to it any more: it is met again when it is heard again.
  void lose(PeerId peer) {
    contacts_.erase(peer);
    std::erase_if(met_, [peer](const NearPeer& each) { return each.peer == peer; });
  }
  /// Those whom `doubted` names are taken to have been silent since `then`.
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
  /// This peer cannot take in what it is sent: fewer from now on. Or it can: one more.
  void lower_limit();
  void raise_limit();
  std::size_t limit() const { return limit_; }

  struct Changes {
    std::vector<Cell> listen;  ///< of level 0: who is there; above: what they come to
    std::vector<Cell> unlisten;
    std::vector<PeerId> meet;
    std::vector<PeerId> part;

    bool empty() const {
      return listen.empty() && unlisten.empty() && meet.empty() && part.empty();
    }
  };
  /// What is to change now. Valid until the next call. @param served  there is a server; without
  /// one nobody is heard, and silence says nothing
  const Changes& update(bool served, std::int64_t now);

  /// m: how far this peer hears.
  double hears() const { return hears_; }
  std::size_t contacts() const { return contacts_.size(); }
  std::size_t met() const { return met_.size(); }
  /// By ascending id, as of the last update().
  std::span<const NearPeer> met_peers() const { return met_; }
  /// Peers that are in a cell, as far as is known here.
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
  std::optional<pbd::Vec3> cells_about_;  ///< where the user was when they were chosen
  Changes changes_;
  std::vector<double> distances_;  ///< scratch
};

}  // namespace tandem::nats
