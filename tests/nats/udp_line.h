// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "nats/loopback_socket.h"
#include "tandem/pbd/random.h"

namespace tandem::nats::testing {

/// Stands between two UDP sockets that do not know each other's addresses, and loses a part of what
/// passes, by a seed.
class UdpLine {
 public:
  explicit UdpLine(std::uint64_t seed) : dice_(seed) {
    thread_ = std::thread([this] { run(); });
  }
  ~UdpLine() {
    stop_ = true;
    thread_.join();
  }
  UdpLine(const UdpLine&) = delete;
  UdpLine& operator=(const UdpLine&) = delete;

  std::uint16_t port() const { return socket_.port(); }
  void join(std::uint16_t first, std::uint16_t second) {
    first_ = first;
    second_ = second;
  }
  void lose(double part) { loss_ = part; }
  /// The last datagram of the first.
  std::vector<char> last() const {
    const std::scoped_lock lock(mutex_);
    return last_;
  }
  /// Sends these bytes to a port of this machine as nobody that anyone knows.
  static void intrude(std::uint16_t port, std::span<const char> bytes) {
    const int stranger = socket(AF_INET, SOCK_DGRAM, 0);
    const sockaddr_in to = loopback(port);
    (void)sendto(stranger, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                 sizeof to);
    close(stranger);
  }

 private:
  void run() {
    std::array<char, 2048> bytes{};
    while (!stop_) {
      pollfd waits{socket_.fd(), POLLIN, 0};
      if (poll(&waits, 1, 20) <= 0) continue;
      sockaddr_in from{};
      socklen_t length = sizeof from;
      const ssize_t got = recvfrom(socket_.fd(), bytes.data(), bytes.size(), 0,
                                   reinterpret_cast<sockaddr*>(&from), &length);
      if (got < 0) continue;
      const bool onward = ntohs(from.sin_port) == first_;
      if (!onward && ntohs(from.sin_port) != second_) continue;
      if (onward) {
        const std::scoped_lock lock(mutex_);
        last_.assign(bytes.data(), bytes.data() + got);
      }
      if (dice_.uniform(0.0, 1.0) < loss_) continue;
      const sockaddr_in to = loopback(onward ? second_ : first_);
      (void)sendto(socket_.fd(), bytes.data(), static_cast<std::size_t>(got), 0,
                   reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }

  pbd::SplitMix64 dice_;
  LoopbackSocket socket_{SOCK_DGRAM};
  std::atomic<std::uint16_t> first_ = 0;
  std::atomic<std::uint16_t> second_ = 0;
  std::atomic<double> loss_ = 0.0;
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;
  std::vector<char> last_;
  std::thread thread_;
};

}  // namespace tandem::nats::testing
