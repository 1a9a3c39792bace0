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

/// Carries signals beside a peer's own packets; sits between a peer and its transport. A signal
/// takes effect once at each peer, at its time or on later arrival. Newcomers receive all known
/// signals.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Signals final : public SideChannel, public SignalSink {
 public:
  /// Limits of signals accepted from others, in total and from one of them.
  static constexpr std::size_t kMaxSignals = 1024;
  static constexpr std::size_t kMaxFromOne = 64;
  static constexpr consensus::SessionTime kSameSignal = 2'000'000'000;  ///< ns

  /// Must outlive it.
  /// @param timestamps  how to read the times of others. Arrival: waiting for a link delays
  /// signals, and two within kSameSignal count as one
  explicit Signals(consensus::Transport& inner,
                   consensus::TimestampSource timestamps = consensus::TimestampSource::Sender)
      : SideChannel(inner), timestamps_(timestamps) {}

  /// Sends known signals to newcomers. @param now  ns, session time
  void update(consensus::SessionTime now);
  void raise(const Signal& signal) override;
  /// Takes the next due signal, in order of time.
  bool take(consensus::SessionTime now, Signal& signal);

 private:
  bool hear(const consensus::Packet& packet) override;
  void say(consensus::PeerId to, const Signal& signal);
  /// The signal's time on the own clock. @param said  ns, on the sender's, when it was sent
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
  std::map<consensus::PeerId, std::size_t> told_;  ///< new ones, by first sender
  std::vector<consensus::PeerId> company_;         ///< connected at the last update()
  consensus::SessionTime now_ = 0;
};

}  // namespace tandem::demos
