// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>
#include <set>
#include <vector>

#include "scenes/controls.h"
#include "session/side_channel.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos {

/// Carries signals beside a peer's own packets; stands between a peer and its transport. Each
/// signal takes effect once at each peer, at its time or when it is heard, if that is later. Peers
/// tell newcomers all that they know.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Signals final : public SideChannel, public SignalSink {
 public:
  /// Beyond these nothing more is taken from others, and nothing more from one of them.
  static constexpr std::size_t kMaxSignals = 1024;
  static constexpr std::size_t kMaxFromOne = 64;
  static constexpr consensus::SessionTime kSameSignal = 2'000'000'000;  ///< ns

  /// Must outlive it.
  /// @param timestamps  by what the times of others are read: on receipt, what waited for its link
  /// is
  ///   as late, and what two peers tell within kSameSignal is one signal
  explicit Signals(consensus::Transport& inner,
                   consensus::TimestampSource timestamps = consensus::TimestampSource::Sender)
      : SideChannel(inner), timestamps_(timestamps) {}

  /// Tell newcomers. @param now  ns, session time
  void update(consensus::SessionTime now);
  void raise(const Signal& signal) override;
  /// The next signal whose time has come and that was not taken yet, in order of time.
  bool take(consensus::SessionTime now, Signal& signal);

 private:
  bool hear(const consensus::Packet& packet) override;
  void say(consensus::PeerId to, const Signal& signal);
  /// By the own clock. @param said  ns, by the sender's, when it was told
  consensus::SessionTime dated(const consensus::Packet& packet, consensus::SessionTime time,
                               consensus::SessionTime said) const;
  bool knows(const Signal& signal) const;

  struct InTime {
    bool operator()(const Signal& a, const Signal& b) const {
      return a.time != b.time ? a.time < b.time : a.code < b.code;
    }
  };
  consensus::TimestampSource timestamps_;
  std::set<Signal, InTime> known_;
  std::set<Signal, InTime> taken_;
  std::map<consensus::PeerId, std::size_t> told_;  ///< new ones, by who told them first
  std::vector<consensus::PeerId> company_;         ///< connected at the last update()
  consensus::SessionTime now_ = 0;
};

}  // namespace tandem::demos
