// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem {

/// Who is connected, and what has changed between the last two looks.
class Roster {
 public:
  void look(const consensus::Transport& transport) {
    transport.list_peers(seen_);
    joined_.clear();
    left_.clear();
    for (const consensus::PeerStatus& peer : seen_) {
      if (peer.connected && std::find(here_.begin(), here_.end(), peer.id) == here_.end()) {
        joined_.push_back(peer.id);
      }
    }
    for (const consensus::PeerId id : here_) {
      if (!connected(id)) left_.push_back(id);
    }
    std::erase_if(here_, [this](consensus::PeerId id) { return !connected(id); });
    here_.insert(here_.end(), joined_.begin(), joined_.end());
  }
  const std::vector<consensus::PeerId>& joined() const { return joined_; }
  const std::vector<consensus::PeerId>& left() const { return left_; }

 private:
  bool connected(consensus::PeerId id) const {
    return std::any_of(seen_.begin(), seen_.end(), [id](const consensus::PeerStatus& peer) {
      return peer.id == id && peer.connected;
    });
  }

  std::vector<consensus::PeerId> here_;
  std::vector<consensus::PeerId> joined_;
  std::vector<consensus::PeerId> left_;
  std::vector<consensus::PeerStatus> seen_;
};

}  // namespace tandem
