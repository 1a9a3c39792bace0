// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <arpa/inet.h>
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

#include "support/catch.h"

namespace tandem::nats::testing {

/// A thin line between one client and a server: what the server says passes at so many bytes a
/// second, and the rest waits in the server.
class Relay {
 public:
  explicit Relay(std::uint16_t server) : server_(server) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    REQUIRE(listener_ >= 0);
    sockaddr_in address = loopback(0);
    REQUIRE(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(listen(listener_, 4) == 0);
    socklen_t length = sizeof address;
    REQUIRE(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) == 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~Relay() {
    stop_ = true;
    thread_.join();
    close(listener_);
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  std::uint16_t port() const { return port_; }
  /// 0: as fast as it comes.
  void limit(double bytes_per_s) { rate_ = bytes_per_s; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int kSmall = 16 * 1024;

  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }

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
      pollfd waiting{listener_, POLLIN, 0};
      if (poll(&waiting, 1, 20) <= 0) continue;
      const int client = accept(listener_, nullptr, nullptr);
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
  std::uint16_t port_ = 0;
  int listener_ = -1;
  std::atomic<double> rate_ = 0.0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace tandem::nats::testing
