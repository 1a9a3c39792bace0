// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "session/side_channel.h"

namespace tandem::demos {

/// What is known of the way to one peer.
struct LinkFigures {
  double loss = 0.0;         ///< share of words from there that were lost, last one to two minutes
  double round_trip = -1.0;  ///< s, until the answer is looked at; -1 = none has come
};

/// Small numbered words between peers, beside a session's packets, that show what the way does to
/// states: how many are lost, and how long there and back takes from one program to the other, the
/// wait for each one's next step included.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class LinkWords final : public SideChannel {
 public:
  static constexpr std::int64_t kInterval = 200'000'000;   ///< ns, between two words to a peer
  static constexpr std::int64_t kPeriod = 60'000'000'000;  ///< ns

  /// Must outlive it.
  explicit LinkWords(consensus::Transport& inner) : SideChannel(inner) {}

  /// Speak where it is time; before each drain(), which dates what has come by it.
  /// @param now  ns, of a clock of this process that never steps
  void update(std::int64_t now);
  LinkFigures figures(consensus::PeerId peer) const;

 private:
  struct Count {
    std::uint64_t expected = 0;
    std::uint64_t heard = 0;
  };
  struct Link {
    std::uint32_t said = 0;               ///< number of the last word to there
    std::optional<std::uint32_t> newest;  ///< number of the newest word from there
    std::int64_t their_time = 0;          ///< ns, of theirs: in that word
    std::int64_t heard_at = 0;            ///< ns
    std::int64_t round_trip = -1;         ///< ns, smoothed
    Count now, before;
  };

  bool hear(const consensus::Packet& packet) override;
  void count(Link& link, std::uint32_t number);

  std::map<consensus::PeerId, Link> links_;  ///< of connected peers
  std::int64_t now_ = 0;
  std::int64_t next_word_ = 0;
  std::int64_t next_period_ = 0;
};

}  // namespace tandem::demos
