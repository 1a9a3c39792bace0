// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "nats/loopback_socket.h"

namespace tandem::nats::testing {

/// A thin line between one client and a server: what the server says passes at so many bytes a
/// second, and the rest waits in the server.
class Relay {
 public:
  explicit Relay(std::uint16_t server) : server_(server) {
    thread_ = std::thread([this] { run(); });
  }
  ~Relay() {
    stop_ = true;
    thread_.join();
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  std::uint16_t port() const { return listener_.port(); }
  /// 0: as fast as it comes.
  void limit(double bytes_per_s) { rate_ = bytes_per_s; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kSmall = 16 * 1024;

  static bool pass(int from, int to, std::size_t most, std::size_t& passed) {
    std::array<char, 8192> bytes{};
    const ssize_t got = recv(from, bytes.data(), std::min(most, bytes.size()), MSG_DONTWAIT);
    if (got == 0) return false;
    passed = got > 0 ? static_cast<std::size_t>(got) : 0;
    for (std::size_t sent = 0; sent < passed;) {
      const ssize_t now = ::send(to, bytes.data() + sent, passed - sent, MSG_NOSIGNAL);
      if (now <= 0) return false;
      sent += static_cast<std::size_t>(now);
    }
    return true;
  }

  void run() {
    while (!stop_) {
      pollfd waiting{listener_.fd(), POLLIN, 0};
      if (poll(&waiting, 1, 20) <= 0) continue;
      const int client = accept(listener_.fd(), nullptr, nullptr);
      const int server = socket(AF_INET, SOCK_STREAM, 0);
      setsockopt(server, SOL_SOCKET, SO_RCVBUF, &kSmall, sizeof kSmall);
      sockaddr_in address = loopback(server_);
      if (connect(server, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
        serve(client, server);
      }
      close(client);
      close(server);
    }
  }

  void serve(int client, int server) {
    double room = 0.0;
    auto last = Clock::now();
    while (!stop_) {
      std::array<pollfd, 2> both{{{client, POLLIN, 0}, {server, POLLIN, 0}}};
      poll(both.data(), 2, 5);
      std::size_t passed = 0;
      if (!pass(client, server, 8192, passed)) return;
      const auto now = Clock::now();
      const double rate = rate_;
      room = std::min(8192.0, room + rate * std::chrono::duration<double>(now - last).count());
      last = now;
      if (rate > 0.0 && room < 512.0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        continue;
      }
      if (!pass(server, client, rate > 0.0 ? static_cast<std::size_t>(room) : 8192, passed)) return;
      room -= static_cast<double>(passed);
    }
  }

  std::uint16_t server_;
  LoopbackSocket listener_{SOCK_STREAM};
  std::atomic<double> rate_ = 0.0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace tandem::nats::testing
