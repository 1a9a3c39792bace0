// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "session/side_channel.h"

namespace tandem::demos {

/// Quality of the link from one peer.
struct LinkFigures {
  double loss = 0.0;         ///< fraction of words lost over the last one to two minutes
  double round_trip = -1.0;  ///< s, including processing; -1 = none yet
};

/// Small numbered probes between peers, beside a session's packets. They measure the loss and the
/// round trip from program to program, including the waits for steps.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class LinkWords final : public SideChannel {
 public:
  static constexpr std::int64_t kInterval = 200'000'000;   ///< ns, between probes to a peer
  static constexpr std::int64_t kPeriod = 60'000'000'000;  ///< ns

  /// Must outlive it.
  explicit LinkWords(consensus::Transport& inner) : SideChannel(inner) {}

  /// Sends due probes; call before each drain(), whose packets it dates.
  /// @param now  ns, monotonic clock of this process
  void update(std::int64_t now);
  LinkFigures figures(consensus::PeerId peer) const;

 private:
  struct Count {
    std::uint64_t expected = 0;
    std::uint64_t heard = 0;
  };
  struct Link {
    std::uint32_t said = 0;               ///< number of the last probe sent
    std::optional<std::uint32_t> newest;  ///< number of the newest probe received
    std::int64_t their_time = 0;          ///< ns, sender's time in that probe
    std::int64_t heard_at = 0;            ///< ns
    std::int64_t round_trip = -1;         ///< ns, smoothed
    Count now, before;
  };

  bool hear(const consensus::Packet& packet) override;
  void count(Link& link, std::uint32_t number);

  std::map<consensus::PeerId, Link> links_;
  std::int64_t now_ = 0;
  std::int64_t next_word_ = 0;
  std::int64_t next_period_ = 0;
};

}  // namespace tandem::demos
