// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <set>
#include <vector>

#include "scenes/controls.h"
#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// Carries signals beside a peer's own packets; stands between a peer and its transport. Each
/// signal takes effect once at each peer, at its time or when it is heard, if that is later. Peers
/// tell newcomers all that they know.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Signals final : public consensus::Transport, public SignalSink {
 public:
  /// Beyond this nothing more is taken from others.
  static constexpr std::size_t kMaxSignals = 1024;
  /// ns: what is further from now is nobody's signal.
  static constexpr consensus::SessionTime kMaxDistance = 86'400'000'000'000;

  /// Must outlive it.
  explicit Signals(consensus::Transport& inner) : inner_(inner) {}

  /// Tell newcomers. @param now  ns, session time
  void update(consensus::SessionTime now);
  void raise(const Signal& signal) override;
  /// The next signal whose time has come and that was not taken yet, in order of time.
  bool take(consensus::SessionTime now, Signal& signal);

  // consensus::Transport
  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override {
    return inner_.post(to, bytes, delivery);
  }
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override {
    inner_.drop(peer, reason);
  }
  std::vector<consensus::PeerStatus> peers() const override { return inner_.peers(); }

 private:
  bool hear(const consensus::Packet& packet);
  void say(consensus::PeerId to, const Signal& signal);

  struct InTime {
    bool operator()(const Signal& a, const Signal& b) const {
      return a.time != b.time ? a.time < b.time : a.code < b.code;
    }
  };
  consensus::Transport& inner_;
  std::set<Signal, InTime> known_;
  std::set<Signal, InTime> taken_;
  std::vector<consensus::PeerId> company_;  ///< connected at the last update()
  consensus::SessionTime now_ = 0;
};

}  // namespace tandem::demos
