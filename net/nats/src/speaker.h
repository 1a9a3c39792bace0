// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>

#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"

namespace tandem::nats {

/// Elects the peer that summarises a cell: the lowest id of those that are in it and may. Each peer
/// has one of these per level, for its own cell. There are no messages for it: a peer that has
/// heard no lower id for a while begins, and one that hears a lower id stops. Times in ns.
class Speaker {
 public:
  static constexpr std::int64_t kPatience = 1'500'000'000;
  static constexpr std::int64_t kSpread = 1'000'000'000;  ///< by id, so that not all begin at once

  Speaker(consensus::PeerId self, std::int64_t now)
      : self_(self),
        patience_(kPatience + static_cast<std::int64_t>(self % 64) * (kSpread / 64)),
        quiet_since_(now) {}

  /// This peer is in that cell.
  void enter(const Cell& cell, std::int64_t now) {
    if (cell == cell_) return;
    cell_ = cell;
    quiet_since_ = now;
  }
  const Cell& cell() const { return cell_; }
  /// `peer` has summarised that cell.
  void hear(const Cell& cell, consensus::PeerId peer, std::int64_t now) {
    if (cell == cell_ && peer < self_) quiet_since_ = now;
  }
  bool speaks(std::int64_t now) const { return now - quiet_since_ > patience_; }
  /// Whether a summary is due, `period` ns after the last one.
  bool due(std::int64_t period, std::int64_t now) {
    if (!speaks(now) || now < next_) return false;
    next_ = std::max(next_ + period, now);
    return true;
  }

 private:
  consensus::PeerId self_;
  std::int64_t patience_;
  std::int64_t quiet_since_;
  std::int64_t next_ = INT64_MIN / 2;
  Cell cell_{-1, 0, 0};
};

}  // namespace tandem::nats
