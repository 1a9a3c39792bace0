// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <random>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/types.h"

namespace tandem::extreme_bench {

/// Adds noise to the states received by another transport.
class NoisyTransport final : public consensus::Transport {
 public:
  /// @param distance  m, standard deviation of each coordinate     @param angle  rad, about each
  /// axis
  NoisyTransport(consensus::Transport& inner, double distance, double angle, std::uint64_t seed)
      : inner_(inner), distance_(distance), angle_(angle), random_(seed) {}

  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override {
    return inner_.post(to, bytes, delivery);
  }
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override {
    return inner_.max_packet_bytes(delivery);
  }
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override {
    inner_.drop(peer, reason);
  }
  std::vector<consensus::PeerStatus> peers() const override { return inner_.peers(); }

 private:
  /// Normally distributed, the same with every standard library.
  double normal();
  pbd::Vec3 normals() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }

  consensus::Transport& inner_;
  double distance_;
  double angle_;
  std::mt19937_64 random_;
  consensus::DecodedPacket packet_;
};

}  // namespace tandem::extreme_bench
