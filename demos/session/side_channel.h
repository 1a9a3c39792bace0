// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// A transport that carries its own packets among the session's.
class SideChannel : public consensus::Transport {
 public:
  /// ns: times farther from now are invalid.
  static constexpr consensus::SessionTime kMaxDistance = 86'400'000'000'000;

  /// Must outlive it.
  explicit SideChannel(consensus::Transport& inner) : inner_(inner) {}

  // consensus::Transport
  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override {
    return inner_.post(to, bytes, delivery);
  }
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override {
    return inner_.max_packet_bytes(delivery);
  }
  void drain(std::vector<consensus::Packet>& out) override {
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    inner_.drain(out);
    out.erase(std::remove_if(out.begin() + first, out.end(),
                             [this](const consensus::Packet& packet) { return hear(packet); }),
              out.end());
  }
  void drop(consensus::PeerId peer, const std::string& reason) override {
    inner_.drop(peer, reason);
  }
  std::vector<consensus::PeerStatus> peers() const override { return inner_.peers(); }

 protected:
  /// Handles the packet if it is our own; returns whether it was.
  virtual bool hear(const consensus::Packet& packet) = 0;
  /// True if a received time is within kMaxDistance.
  static bool plausible(consensus::SessionTime time, consensus::SessionTime now) {
    return time > now - kMaxDistance && time < now + kMaxDistance;
  }

 private:
  consensus::Transport& inner_;
};

}  // namespace tandem::demos
