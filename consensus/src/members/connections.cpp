// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "members/connections.h"

namespace tandem::consensus {

void Connections::refresh() {
  peers_ = transport_.peers();
  std::erase_if(newcomers_, [this](PeerId id) {
    return std::ranges::none_of(
        peers_, [id](const PeerStatus& peer) { return peer.id == id && peer.connected; });
  });
  // Whoever comes back says its indices again.
  std::erase_if(connected_, [this](PeerId id) {
    const auto at = std::ranges::lower_bound(peers_, id, {}, &PeerStatus::id);
    if (at != peers_.end() && at->id == id && at->connected) return false;
    indices_.forget(id);
    return true;
  });
  for (const PeerStatus& peer : peers_) {
    const auto at = std::lower_bound(connected_.begin(), connected_.end(), peer.id);
    const bool known = at != connected_.end() && *at == peer.id;
    if (peer.connected && !known) {
      // Who was there before the first states were sent hears those.
      if (has_sent_) newcomers_.push_back(peer.id);
      connected_.insert(at, peer.id);
    }
  }
}

}  // namespace tandem::consensus
