// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The same fifteen networks over TCP, as a stream feels them: what is lost or held back makes all
// that follows late, what comes twice nobody sees. Real sockets, all fifteen at once.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "conditions.h"
#include "consensus/peer_fixture.h"
#include "raw_peer.h"
#include "support/catch.h"

namespace tcp_conditions_test {

using namespace tandem::net;
using conditions_test::Condition;
using conditions_test::kConditions;
using raw::eventually;
using raw::linked;
using raw::status;
using Clock = std::chrono::steady_clock;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerOptions;
using tandem::consensus::testing::kBody;
using tandem::consensus::testing::kWeightless;
using tandem::consensus::testing::Site;
using tandem::pbd::Vec3;

namespace {

/// s: a sender that has lost something says it again no sooner.
constexpr double kResend = 0.2;

/// Passes one connection on as the condition says. One thread of its own.
class Relay {
 public:
  Relay(const Condition& condition, std::uint16_t target, std::uint64_t seed)
      : condition_(condition), target_(target), state_(seed), thread_([this] { run(); }) {}
  ~Relay() {
    stop_ = true;
    thread_.join();
  }
  std::uint16_t port() const { return listener_.port(); }

 private:
  struct Chunk {
    Clock::time_point due;
    raw::Bytes bytes;
  };
  struct Way {
    int from = -1;
    int to = -1;
    std::deque<Chunk> flying;
    Clock::time_point last{};
    Clock::time_point free{};
  };
  class Door : public raw::Listener {
   public:
    int fd() const { return fd_; }
  };

  double random() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  Clock::duration seconds(double s) const {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
  }

  /// Whether the way is still open.
  bool pump(Way& way) {
    const auto now = Clock::now();
    pollfd readable{.fd = way.from, .events = POLLIN, .revents = 0};
    // Waiting packets fill the sender's queue, as in any network.
    if (way.flying.size() < 64 && ::poll(&readable, 1, 0) > 0) {
      raw::Bytes bytes(1400);
      const ssize_t n = ::recv(way.from, bytes.data(), bytes.size(), 0);
      if (n <= 0) return false;
      bytes.resize(static_cast<std::size_t>(n));
      double late = condition_.lag + condition_.jitter * random();
      if (random() < condition_.loss) late += kResend;
      if (random() < condition_.reorder) late += 0.05;
      auto leaves = now;
      if (condition_.kbit > 0.0) {
        way.free =
            std::max(way.free, now) + seconds(8e-3 * static_cast<double>(n + 40) / condition_.kbit);
        leaves = way.free;
      }
      way.last = std::max(way.last, leaves + seconds(late));
      way.flying.push_back({.due = way.last, .bytes = std::move(bytes)});
    }
    while (!way.flying.empty() && way.flying.front().due <= now) {
      const raw::Bytes& bytes = way.flying.front().bytes;
      for (std::size_t at = 0; at < bytes.size();) {
        const ssize_t n = ::send(way.to, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
        if (n <= 0) return false;
        at += static_cast<std::size_t>(n);
      }
      way.flying.pop_front();
    }
    return true;
  }

  void run() {
    while (!stop_) {
      pollfd door{.fd = listener_.fd(), .events = POLLIN, .revents = 0};
      if (::poll(&door, 1, 5) <= 0) continue;
      const int dialler = ::accept(listener_.fd(), nullptr, nullptr);
      const int target = ::socket(AF_INET, SOCK_STREAM, 0);
      const int on = 1;
      ::setsockopt(target, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      ::setsockopt(dialler, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(target_);
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      if (::connect(target, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
        Way up{.from = dialler, .to = target};
        Way down{.from = target, .to = dialler};
        while (!stop_ && pump(up) && pump(down)) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
      }
      tandem::testing::close_socket(dialler);
      tandem::testing::close_socket(target);
    }
  }

  const Condition condition_;
  const std::uint16_t target_;
  std::uint64_t state_;
  Door listener_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Two transports with a relay between them; only one dials.
struct Pair {
  Pair(const Condition& condition_in, std::uint64_t seed) : condition(condition_in) {
    TcpOptions first = raw::options(1);
    first.idle_timeout = std::chrono::seconds(20);
    a = std::make_unique<TcpTransport>(first);
    relay = std::make_unique<Relay>(condition, a->local_port(), seed);
    TcpOptions second = raw::options(2, {relay->port()});
    second.listen_port.reset();
    second.idle_timeout = std::chrono::seconds(20);
    b = std::make_unique<TcpTransport>(second);
  }

  Condition condition;
  std::unique_ptr<TcpTransport> a;
  std::unique_ptr<Relay> relay;
  std::unique_ptr<TcpTransport> b;
  std::uint64_t messages = 0;
  std::uint64_t next = 0;
  std::uint64_t posted = 0;
  std::uint64_t states = 0;
  std::uint64_t last_state = 0;
  bool in_order = true;
};

}  // namespace

TEST_CASE("conditions: over TCP all messages come in order and once despite losses",
          "[net][socket]") {
  const raw::LeakCheck leaks;
  std::vector<std::unique_ptr<Pair>> pairs;
  for (const Condition& condition : kConditions) {
    pairs.push_back(std::make_unique<Pair>(condition, pairs.size() + 1));
  }
  REQUIRE(eventually([&] {
    return std::ranges::all_of(pairs, [](const auto& pair) { return linked(*pair->a, *pair->b); });
  }));
  const auto hear = [](Pair& pair) {
    std::vector<Packet> packets;
    pair.b->drain(packets);
    for (const Packet& packet : packets) {
      const std::uint64_t value = raw::number(std::span(packet.bytes).first(8));
      if (packet.bytes.size() == 8) {
        pair.in_order = pair.in_order && value == pair.next++;
      } else {
        pair.in_order = pair.in_order && (pair.states == 0 || value > pair.last_state);
        pair.last_state = value;
        ++pair.states;
      }
    }
  };
  for (int step = 0; step < 120; ++step) {
    for (const auto& pair : pairs) {
      raw::Bytes state = raw::le(pair->posted++, 8);
      state.resize(100);
      (void)pair->a->post(2, state, Delivery::Newest);
      if (step % 4 == 0 && pair->a->post(2, raw::le(pair->messages, 8), Delivery::Reliable)) {
        ++pair->messages;
      }
      hear(*pair);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
  }
  CHECK(eventually([&] {
    return std::ranges::all_of(pairs, [&](const auto& pair) {
      hear(*pair);
      return pair->next == pair->messages && pair->last_state + 1 == pair->posted;
    });
  }));
  for (const auto& pair : pairs) {
    CAPTURE(pair->condition.name);
    CHECK(pair->in_order);
    CHECK(pair->messages == 30);
    CHECK(pair->next == 30);
    CHECK(linked(*pair->a, *pair->b));
    CHECK(pair->states + status(*pair->a, 2).dropped_queue_full == pair->posted);
  }
}

TEST_CASE("conditions: over TCP a body that was carried comes to rest in one place",
          "[net][socket]") {
  const raw::LeakCheck leaks;
  std::vector<std::unique_ptr<Pair>> pairs;
  std::vector<std::unique_ptr<Site>> sites;
  for (const Condition& condition : kConditions) {
    pairs.push_back(std::make_unique<Pair>(condition, pairs.size() + 1));
    for (TcpTransport* line : {pairs.back()->a.get(), pairs.back()->b.get()}) {
      sites.push_back(std::make_unique<Site>(*line, PeerOptions{}, kWeightless));
      sites.back()->share(tandem::consensus::testing::cube({0.0, 0.0, 1.0}));
    }
  }
  REQUIRE(eventually([&] {
    return std::ranges::all_of(pairs, [](const auto& pair) { return linked(*pair->a, *pair->b); });
  }));
  SessionClock clock;
  PhysicsClock physics({}, clock.now());
  std::vector<tandem::consensus::GrabId> hands;
  std::int64_t steps = 0;
  const auto step = [&] {
    const ClockTick tick = physics.advance(clock.now());
    tandem::consensus::SessionTime time = physics.physics_time();
    for (const std::int64_t each : tick.steps) time -= each;
    for (const std::int64_t each : tick.steps) {
      const double turn = std::clamp(static_cast<double>(steps) / 60.0, 0.0, 2.0);
      const Vec3 anchor(0.4 * std::sin(2.0 * turn), 0.0, 1.0 + 0.4 * turn);
      for (std::size_t i = 0; i < sites.size(); ++i) {
        Site& site = *sites[i];
        if (i % 2 == 0 && steps == 0) {
          hands.push_back(site.peer->grab({.body = kBody,
                                           .anchor_w = anchor,
                                           .stiffness = 400.0,
                                           .damping = 40.0,
                                           .max_force = 200.0}));
        }
        if (i % 2 == 0) site.peer->move(hands[i / 2], anchor, time);
        site.peer->before_step(time);
        site.solver.step(site.world, seconds(each));
        site.peer->after_step(time + each);
      }
      time += each;
      ++steps;
    }
  };
  const auto apart = [&](std::size_t i) {
    return (sites[2 * i]->x() - sites[2 * i + 1]->x()).norm();
  };
  const Vec3 end(0.4 * std::sin(4.0), 0.0, 1.8);
  const bool settled = eventually([&] {
    step();
    if (steps < 240) return false;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (apart(i) > 2e-3 || (sites[2 * i + 1]->x() - end).norm() > 2e-3) return false;
    }
    return true;
  });
  CHECK(settled);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    CAPTURE(pairs[i]->condition.name);
    CHECK(apart(i) < 2e-3);
    CHECK((sites[2 * i + 1]->x() - end).norm() < 2e-3);
  }
  // Peers leave their worlds before their transports go.
  sites.clear();
}

}  // namespace tcp_conditions_test
