// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "sim_link.h"
#include "tandem/pbd/bytes.h"
#include "udp_node.h"

namespace protocol {

/// The key that a peer keeps over its starts.
inline tandem::net::crypto::KeyPair identity_of(tandem::consensus::PeerId peer) {
  return tandem::net::crypto::make_key_pair(seeded(500 + peer));
}

/// Whole processes but for their sockets, over seeded paths, in virtual time.
class World {
 public:
  explicit World(const PathOptions& path = {}) : path_(path) {}

  tandem::net::UdpNode& start(tandem::consensus::PeerId peer, std::uint64_t incarnation = 1,
                              std::size_t max_peers = 64) {
    tandem::net::UdpNodeOptions options;
    options.handshake.self = peer;
    options.handshake.incarnation = incarnation;
    options.handshake.scene_hash = 42;
    options.max_peers = max_peers;
    options.start = now;
    options.correction = static_cast<std::int64_t>(peer) * kSecond;
    options.handshake.session_key = secret(1000);
    options.handshake.identity = identity_of(peer);
    ++starts_;
    change(options);
    nodes_[peer] = std::make_unique<tandem::net::UdpNode>(
        options, seeded(7000 + starts_),
        [this, peer](std::span<const std::byte> out, const tandem::net::Address& to) {
          tap(copy(out));
          path(where(peer), to).send(copy(out), now);
        });
    return *nodes_[peer];
  }
  /// For all processes that start from then on.
  std::function<void(tandem::net::UdpNodeOptions&)> change = [](auto&) {};
  /// Hears all datagrams, for any receiver.
  std::function<void(const Bytes&)> tap = [](const Bytes&) {};
  /// Its packets leave from there from now on, and reach it there alone.
  void move(tandem::consensus::PeerId peer, const tandem::net::Address& to) { moved_[peer] = to; }
  tandem::net::Address where(tandem::consensus::PeerId peer) const {
    const auto at = moved_.find(peer);
    return at != moved_.end() ? at->second : address_of(peer);
  }
  /// Datagrams that arrive there are kept for arrived().
  void watch(const tandem::net::Address& address) { watched_.insert(address); }
  std::vector<Bytes> arrived(const tandem::net::Address& from, const tandem::net::Address& to) {
    return path(from, to).arrived(now);
  }
  void stop(tandem::consensus::PeerId peer) { nodes_.erase(peer); }
  tandem::net::UdpNode& node(tandem::consensus::PeerId peer) { return *nodes_.at(peer); }
  Path& path(const tandem::net::Address& from, const tandem::net::Address& to) {
    return paths_.try_emplace({from, to}, path_, paths_.size() + 1).first->second;
  }

  void run(std::int64_t duration) {
    for (const std::int64_t end = now + duration; now < end; now += kMs) {
      each_step();
      for (auto& [peer, node] : nodes_) node->poll(now);
      for (auto& [ends, path] : paths_) {
        const tandem::net::Address target = ends.second;
        const auto to = std::ranges::find_if(
            nodes_, [&](const auto& entry) { return where(entry.first) == target; });
        if (watched_.contains(target)) continue;
        for (const Bytes& datagram : path.arrived(now)) {
          if (to != nodes_.end()) to->second->on_datagram(datagram, ends.first, now);
        }
      }
    }
  }

  std::function<void()> each_step = [] {};
  std::int64_t now = 0;

 private:
  PathOptions path_;
  std::map<std::pair<tandem::net::Address, tandem::net::Address>, Path> paths_;
  std::map<tandem::consensus::PeerId, std::unique_ptr<tandem::net::UdpNode>> nodes_;
  std::map<tandem::consensus::PeerId, tandem::net::Address> moved_;
  std::set<tandem::net::Address> watched_;
  std::uint64_t starts_ = 0;
};

inline tandem::consensus::PeerStatus status(const tandem::net::UdpNode& node,
                                            tandem::consensus::PeerId peer) {
  for (const tandem::consensus::PeerStatus& each : node.peers()) {
    if (each.id == peer) return each;
  }
  return {};
}

inline bool linked(World& world, tandem::consensus::PeerId a, tandem::consensus::PeerId b) {
  return status(world.node(a), b).connected && status(world.node(b), a).connected;
}

inline Bytes number(std::uint64_t value) {
  Bytes out;
  tandem::pbd::ByteWriter(out).u64(value);
  return out;
}

/// Neither hears the other.
inline void cut(World& world, tandem::consensus::PeerId a, tandem::consensus::PeerId b,
                bool whole = false) {
  const PathOptions path = whole ? PathOptions{.delay = 20 * kMs} : PathOptions{.loss = 1.1};
  world.path(address_of(a), address_of(b)).set(path);
  world.path(address_of(b), address_of(a)).set(path);
}

}  // namespace protocol
