// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "tandem/consensus/robust.h"

namespace tandem::consensus {

/// What is noted about each of the others.
class Reports {
 public:
  /// Valid until another peer comes or goes.
  PeerReport& of(PeerId peer) {
    auto it = std::ranges::lower_bound(reports_, peer, {}, &PeerReport::peer);
    if (it == reports_.end() || it->peer != peer)
      it = reports_.insert(it, PeerReport{.peer = peer});
    return *it;
  }
  void forget(PeerId peer) {
    std::erase_if(reports_, [peer](const PeerReport& report) { return report.peer == peer; });
  }
  std::span<const PeerReport> with_counters_of(const Inbox& inbox) {
    for (PeerReport& report : reports_) report.inbox = inbox.counters(report.peer);
    return reports_;
  }

 private:
  std::vector<PeerReport> reports_;  ///< by peer
};

}  // namespace tandem::consensus
