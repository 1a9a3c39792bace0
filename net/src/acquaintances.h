// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::net {

/// Which peers claim to be connected to which: candidates to relay a datagram. Times in ns.
/// Bounded, whatever members claim.
class Acquaintances {
 public:
  using PeerId = consensus::PeerId;

  static constexpr std::int64_t kLife = 10'000'000'000;  // ns, after the last claim
  static constexpr std::size_t kMaxPeers = 256;
  static constexpr std::size_t kMaxWitnesses = 8;  // of one peer

  void note(PeerId peer, PeerId witness, std::int64_t now) {
    auto at = known_.find(peer);
    if (at == known_.end()) {
      if (known_.size() >= kMaxPeers) return;
      at = known_.emplace(peer, Known{.since = now, .witnesses = {}}).first;
    }
    auto& witnesses = at->second.witnesses;
    if (witnesses.size() < kMaxWitnesses || witnesses.contains(witness)) witnesses[witness] = now;
  }

  /// Drops claims that are too old.
  void expire(std::int64_t now) {
    for (auto& [peer, known] : known_) {
      std::erase_if(known.witnesses, [now](const auto& w) { return now - w.second > kLife; });
    }
    std::erase_if(known_, [](const auto& entry) { return entry.second.witnesses.empty(); });
  }

  /// Among the witnesses of `peer` that `usable` accepts, the one with the latest claim; 0 = none.
  template <class Usable>
  PeerId relay(PeerId peer, Usable&& usable) const {
    const auto at = known_.find(peer);
    if (at == known_.end()) return 0;
    PeerId out = 0;
    std::int64_t latest = INT64_MIN;
    for (const auto& [witness, when] : at->second.witnesses) {
      if (when > latest && usable(witness)) {
        out = witness;
        latest = when;
      }
    }
    return out;
  }

  /// A connection to `peer` exists or was just lost: patience begins again.
  void restart(PeerId peer, std::int64_t now) {
    if (const auto at = known_.find(peer); at != known_.end()) at->second.since = now;
  }

  /// Peers known for longer than `patience` without a connection.
  std::vector<PeerId> waiting(std::int64_t patience, std::int64_t now) const {
    std::vector<PeerId> out;
    for (const auto& [peer, known] : known_) {
      if (now - known.since >= patience) out.push_back(peer);
    }
    return out;
  }

 private:
  struct Known {
    std::int64_t since = 0;
    std::map<PeerId, std::int64_t> witnesses;
  };

  std::map<PeerId, Known> known_;
};

}  // namespace tandem::net
