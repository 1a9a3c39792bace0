// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "protocol_support.h"
#include "udp_connection.h"

namespace protocol {

struct PathOptions {
  std::int64_t delay = 20 * kMs;
  std::int64_t jitter = 0;  // uniform, on top
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;            // chance to be held back by kHeldBack, behind what follows
  double kbit = 0.0;               // bottleneck with a queue; 0: none
  std::int64_t queue = 500 * kMs;  // longest wait there, then datagrams are dropped
  std::size_t mtu = SIZE_MAX;      // bytes of UDP payload; longer ones are dropped
};

constexpr std::int64_t kHeldBack = 50 * kMs;

/// One direction, seeded: datagrams with the time at which they arrive.
class Path {
 public:
  Path(const PathOptions& options, std::uint64_t seed) : options_(options), dice_(seed) {}

  void send(const Bytes& datagram, std::int64_t now) {
    bytes_ += datagram.size() + tandem::net::kIpUdpBytes;
    if (dice_.chance(options_.loss) || datagram.size() > options_.mtu) return;
    std::int64_t leaves = now;
    if (options_.kbit > 0.0) {
      if (free_ - now > options_.queue) {
        ++overflowed_;
        return;
      }
      const double bits = 8.0 * static_cast<double>(datagram.size() + tandem::net::kIpUdpBytes);
      free_ = std::max(free_, now) + static_cast<std::int64_t>(bits / options_.kbit * 1e6);
      leaves = free_;
    }
    const int copies = dice_.chance(options_.duplicate) ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
      const auto extra =
          options_.jitter > 0
              ? static_cast<std::int64_t>(dice_.below(static_cast<std::uint64_t>(options_.jitter)))
              : 0;
      const bool held = options_.reorder > 0.0 && dice_.chance(options_.reorder);
      flying_.emplace(leaves + options_.delay + extra + (held ? kHeldBack : 0), datagram);
    }
  }
  std::vector<Bytes> arrived(std::int64_t now) {
    std::vector<Bytes> out;
    const auto end = flying_.upper_bound(now);
    for (auto at = flying_.begin(); at != end; ++at) out.push_back(at->second);
    flying_.erase(flying_.begin(), end);
    return out;
  }
  std::uint64_t bytes() const { return bytes_; }
  /// Datagrams for which the queue had no room.
  std::uint64_t overflowed() const { return overflowed_; }
  void set(const PathOptions& options) { options_ = options; }

 private:
  PathOptions options_;
  Dice dice_;
  std::multimap<std::int64_t, Bytes> flying_;
  std::int64_t free_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t overflowed_ = 0;
};

/// Two connected ends, in steps of a millisecond.
struct Pair {
  Path there;
  Path back;
  tandem::net::UdpConnection a;
  tandem::net::UdpConnection b;
  std::int64_t now = 0;
  std::function<void()> each_step = [] {};

  static tandem::net::Session session(bool first) {
    tandem::net::Session out;
    out.remote.peer = first ? 2 : 1;
    out.remote.receiver = first ? 2 : 1;
    out.remote.idle_timeout_ms = 5000;
    out.send = secret(first ? 1 : 2);
    out.receive = secret(first ? 2 : 1);
    out.local_receiver = first ? 1 : 2;
    return out;
  }

  explicit Pair(const PathOptions& path, const tandem::net::UdpConnectionOptions& options = {},
                std::uint64_t seed = 1)
      : there(path, seed),
        back(path, seed + 1000),
        a(session(true), options, true, 0),
        b(session(false), options, true, 0) {}

  void run(std::int64_t duration) {
    for (const std::int64_t end = now + duration; now < end; now += kMs) {
      each_step();
      pump(a, there);
      pump(b, back);
      for (const Bytes& datagram : there.arrived(now)) b.on_datagram(datagram, now);
      for (const Bytes& datagram : back.arrived(now)) a.on_datagram(datagram, now);
    }
  }

 private:
  void pump(tandem::net::UdpConnection& from, Path& path) const {
    for (auto out = from.poll(now); !out.empty(); out = from.poll(now)) path.send(copy(out), now);
  }
};

}  // namespace protocol
