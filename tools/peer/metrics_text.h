// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "peer/recent_quantiles.h"
#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// Metrics of a peer and its session.
struct PeerFigures {
  struct Remote {
    consensus::PeerStatus status;
    double loss = 0.0;                            ///< fraction of states lost from there
    double round_trip = -1.0;                     ///< s; < 0 = not known
    const RecentQuantiles* divergence = nullptr;  ///< m; null = no states heard
    std::uint64_t over_budget = 0;                ///< packets above a member's rate
    std::uint64_t not_allowed = 0;                ///< states and springs that its role forbids
    std::uint64_t late = 0;     ///< steps that ignored its states as much older than the others'
    std::uint64_t without = 0;  ///< steps without a target, since its states are too old
  };

  std::string scene;
  std::vector<Remote> remotes;
  const RecentQuantiles* step = nullptr;        ///< s, never null
  const RecentQuantiles* divergence = nullptr;  ///< m, of all peers; never null
  double uptime = 0.0;                          ///< s
  double skipped = 0.0;                         ///< s of session time not simulated
  double held = 0.0;                            ///< s, present lag behind session time
  double clock_error = -1.0;                    ///< s, bound; < 0 = not known
  std::uint64_t faults = 0;                     ///< steps after which the world was broken
  std::uint64_t packets_rejected = 0;           ///< malformed
  std::uint64_t bodies_placed = 0;
  /// Refused input from unknown senders, by reason.
  std::vector<std::pair<const char*, std::uint64_t>> refused;

  std::size_t connected() const;
};

/// In the text format of Prometheus, version 0.0.4.
std::string metrics_text(const PeerFigures& figures);
/// In one line, for people.
std::string status_text(const PeerFigures& figures, std::size_t columns);

}  // namespace tandem::demos
