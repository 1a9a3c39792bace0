// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The proxy as a process, between real sockets, in wall time.
#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "processes.h"
#include "support/catch.h"

namespace tandem::demos::proxy_test {
namespace {

using Clock = std::chrono::steady_clock;

struct Datagram {
  std::uint32_t number = 0;
  sockaddr_in from{};
  Clock::time_point at;
};

/// A UDP socket on loopback that says and hears numbers.
class Socket {
 public:
  Socket() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    REQUIRE(fd_ >= 0);
    sockaddr_in own = address(0);
    REQUIRE(bind(fd_, reinterpret_cast<sockaddr*>(&own), sizeof own) == 0);
  }
  ~Socket() { close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  static sockaddr_in address(int port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    result.sin_port = htons(static_cast<std::uint16_t>(port));
    return result;
  }
  int port() const {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    REQUIRE(getsockname(fd_, reinterpret_cast<sockaddr*>(&own), &size) == 0);
    return ntohs(own.sin_port);
  }
  void say(std::uint32_t number, const sockaddr_in& to) const {
    sendto(fd_, &number, sizeof number, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  /// Nothing where nothing comes within a second.
  std::optional<Datagram> hear() const {
    pollfd ready{.fd = fd_, .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, 1000) != 1) return std::nullopt;
    Datagram result;
    socklen_t size = sizeof result.from;
    const ssize_t bytes = recvfrom(fd_, &result.number, sizeof result.number, 0,
                                   reinterpret_cast<sockaddr*>(&result.from), &size);
    result.at = Clock::now();
    if (bytes != ssize_t{sizeof result.number}) return std::nullopt;
    return result;
  }

 private:
  int fd_;
};

/// A proxy before `target`.
class Proxy {
 public:
  Proxy(std::vector<std::string> options, const Socket& target)
      : process_("proxy", with_route(std::move(options), target.port()), folder_.file("out")) {
    REQUIRE(eventually([&] { return folder_.text("out").find('\n') != std::string::npos; }));
    entrance_ = Socket::address(std::atoi(folder_.text("out").c_str()));
  }
  const sockaddr_in& entrance() const { return entrance_; }
  /// Its output at the end.
  std::string end() {
    process_.send(SIGTERM);
    CHECK(process_.wait() == 0);
    return folder_.text("out");
  }

 private:
  static std::vector<std::string> with_route(std::vector<std::string> options, int port) {
    options.push_back("0=127.0.0.1:" + std::to_string(port));
    return options;
  }
  Folder folder_;
  Process process_;
  sockaddr_in entrance_{};
};

TEST_CASE("proxy: without loss all datagrams come, in order, after the latency, both ways",
          "[demos][socket]") {
  constexpr std::uint32_t kCount = 200;
  constexpr std::chrono::milliseconds kLatency{40};
  const Socket client, target;
  Proxy proxy({"--latency", "40"}, target);
  std::vector<Clock::time_point> said(kCount), answered(kCount);
  std::thread there([&] {
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const std::optional<Datagram> heard = target.hear();
      if (!heard || heard->number != i || heard->at - said[i] < kLatency) return;
      answered[i] = Clock::now();
      target.say(i, heard->from);
    }
  });
  for (std::uint32_t i = 0; i < kCount; ++i) {
    said[i] = Clock::now();
    client.say(i, proxy.entrance());
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  std::uint32_t good = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::optional<Datagram> heard = client.hear();
    if (!heard) break;
    if (heard->number == i && heard->at - answered[i] >= kLatency) ++good;
  }
  there.join();
  CHECK(good == kCount);
  CHECK(proxy.end().find("400 in, 400 out, 0 lost") != std::string::npos);
}

/// How many of `count` datagrams from one socket to an address come to another one.
std::size_t arrivals(const Socket& from, const sockaddr_in& to, const Socket& at,
                     std::uint32_t count) {
  std::thread speaker([&] {
    for (std::uint32_t i = 0; i < count; ++i) {
      from.say(i, to);
      // Not more at once than a socket's buffer holds.
      if (i % 10 == 9) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  std::set<std::uint32_t> heard;
  while (const auto datagram = at.hear()) heard.insert(datagram->number);
  speaker.join();
  return heard.size();
}

TEST_CASE("proxy: as many datagrams are lost as it is told, in each direction", "[demos][socket]") {
  const Socket client, target;
  Proxy proxy({"--loss", "0.3", "--seed", "5"}, target);
  std::optional<Datagram> first;
  for (std::uint32_t i = 0; !first && i < 20; ++i) {
    client.say(i, proxy.entrance());
    first = target.hear();
  }
  REQUIRE(first);
  // 1000 trials with a chance of 0.7 each: the standard deviation is 14.5.
  const std::size_t there = arrivals(client, proxy.entrance(), target, 1000);
  CHECK(there > 620);
  CHECK(there < 780);
  const std::size_t back = arrivals(target, first->from, client, 1000);
  CHECK(back > 620);
  CHECK(back < 780);
  CHECK(there != back);  // each direction draws for itself
}

TEST_CASE("proxy: two clients are two to the other end, and each gets its own answers",
          "[demos][socket]") {
  const Socket one, two, target;
  Proxy proxy({}, target);
  one.say(1, proxy.entrance());
  const auto first = target.hear();
  two.say(2, proxy.entrance());
  const auto second = target.hear();
  REQUIRE(first);
  REQUIRE(second);
  CHECK(first->from.sin_port != second->from.sin_port);
  target.say(11, first->from);
  target.say(12, second->from);
  const auto to_one = one.hear();
  const auto to_two = two.hear();
  REQUIRE(to_one);
  REQUIRE(to_two);
  CHECK(to_one->number == 11);
  CHECK(to_two->number == 12);
}

}  // namespace
}  // namespace tandem::demos::proxy_test
