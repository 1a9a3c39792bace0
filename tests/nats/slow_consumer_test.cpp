// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Somebody whose line is too thin for a crowd.
#include <chrono>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include "nats/peers.h"
#include "nats/relay.h"

namespace tandem::nats::slow_consumer_test {
namespace {

using namespace testing;
using Clock = std::chrono::steady_clock;

constexpr int kCrowd = 10;
constexpr PeerId kSlow = 100;

struct Heard {
  std::size_t count = 0;
  Clock::time_point last = Clock::now();
  double longest_gap = 0.0;  // s

  void note(std::size_t packets) {
    if (packets == 0) return;
    const auto now = Clock::now();
    longest_gap = std::max(longest_gap, std::chrono::duration<double>(now - last).count());
    last = now;
    count += packets;
  }
};

NatsOptions crowd_options(std::uint16_t port, PeerId self, std::shared_ptr<NatsHub> hub) {
  NatsOptions out = options_of(port, self);
  out.hub = std::move(hub);
  out.cells.near = 8.0;
  out.cells.min_near = 2;
  return out;
}

class Square {
 public:
  Square() : relay_(server_.port()) {
    const auto hub =
        std::make_shared<NatsHub>(HubOptions{.servers = {{"127.0.0.1", server_.port()}}});
    for (int i = 0; i < kCrowd; ++i) {
      crowd_.push_back(std::make_unique<NatsTransport>(
          crowd_options(server_.port(), static_cast<PeerId>(i + 1), hub)));
      crowd_.back()->set_position(Vec3(0.6 * (i + 1), 0.0, 0.0));
    }
    slow_ = std::make_unique<NatsTransport>(crowd_options(relay_.port(), kSlow, nullptr));
  }

  /// Everybody says a kilobyte to everybody sixty times a second.
  void run(double seconds) {
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    const std::vector<std::byte> state(1000);
    while (Clock::now() < end) {
      std::vector<Packet> packets;
      slow_->drain(packets);
      at_slow_.note(packets.size());
      for (auto& each : crowd_) {
        packets.clear();
        each->drain(packets);
        if (each->self() == 3) {
          at_third_.note(
              static_cast<std::size_t>(std::ranges::count(packets, PeerId{4}, &Packet::from)));
        }
        for (const PeerStatus& peer : each->peers()) {
          if (peer.connected) each->post(peer.id, state, Delivery::Newest);
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(16));
    }
  }
  void begin() {
    at_slow_ = {};
    at_third_ = {};
  }

  Server server_;
  Relay relay_;
  std::vector<std::unique_ptr<NatsTransport>> crowd_;
  std::unique_ptr<NatsTransport> slow_;
  Heard at_slow_;
  Heard at_third_;
};

TEST_CASE("nats: a slow consumer hears fewer and less, never nobody, and nobody else is slowed",
          "[nats][fault]") {
  if (!has_server()) return;
  Square square;
  square.run(2.5);
  REQUIRE(square.slow_->status().met == kCrowd);
  square.begin();
  square.run(1.0);
  const std::size_t before = square.at_slow_.count;
  REQUIRE(before > 100);
  const std::size_t limit = square.slow_->status().limit;

  square.relay_.limit(60e3);  // a tenth of what comes
  square.run(5.0);
  CHECK(square.slow_->status().limit < limit);
  square.begin();
  square.run(3.0);
  INFO("heard " << square.at_slow_.count << " in 3 s, before " << before << " in 1 s; gap "
                << square.at_slow_.longest_gap << " s, lag " << square.slow_->status().lag / 1000000
                << " ms, limit " << square.slow_->status().limit);
  CHECK(square.at_slow_.count > 20);
  CHECK(square.at_slow_.count < 3 * before / 2);
  CHECK(square.at_slow_.longest_gap < 2.0);
  CHECK(square.at_third_.longest_gap < 1.0);
  CHECK(square.at_third_.count > 30);

  square.relay_.limit(0.0);
  square.run(6.0);
  CHECK(square.slow_->status().limit > square.slow_->status().met / 2);
  square.begin();
  square.run(1.0);
  CHECK(square.at_slow_.count > before / 2);
}

}  // namespace
}  // namespace tandem::nats::slow_consumer_test
