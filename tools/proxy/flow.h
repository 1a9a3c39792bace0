// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <asio/ip/udp.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tandem/consensus/virtual_network.h"

namespace tandem::demos {

/// One client's traffic with the target, through a virtual link in real time.
class Flow : public std::enable_shared_from_this<Flow> {
 public:
  using Clock = std::chrono::steady_clock;
  using Endpoint = asio::ip::udp::endpoint;

  /// @param entrance  receives from and sends to the client; must outlive the flow
  /// @param target  the other end
  Flow(asio::io_context& io, asio::ip::udp::socket& entrance, const Endpoint& client,
       const Endpoint& target, const consensus::LinkOptions& link, std::uint64_t seed);

  void begin() { receive(); }
  void forward(std::span<const std::byte> datagram);
  const Endpoint& client() const { return client_; }
  Clock::time_point last_heard() const { return last_heard_; }
  /// Both directions: from the client, to the client.
  std::array<consensus::LinkCounters, 2> counters() const {
    return {network_.counters(kClient, kTarget), network_.counters(kTarget, kClient)};
  }
  void end();

 private:
  static constexpr consensus::PeerId kClient = 1;
  static constexpr consensus::PeerId kTarget = 2;

  void receive();
  void carry(consensus::PeerId from, consensus::PeerId to, std::span<const std::byte> datagram);
  /// Sends due packets, and reschedules itself for the next one.
  void deliver();
  consensus::SessionTime now() const;

  asio::ip::udp::socket& entrance_;
  asio::ip::udp::socket exit_;
  asio::steady_timer timer_;
  Endpoint client_;
  Endpoint target_;
  Endpoint sender_;
  consensus::VirtualNetwork network_;
  consensus::Transport& client_end_;
  consensus::Transport& target_end_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_heard_ = Clock::now();
  std::vector<consensus::Packet> arrived_;
  std::array<std::byte, 65536> buffer_{};
};

}  // namespace tandem::demos
