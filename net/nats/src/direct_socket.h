// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <asio/io_context.hpp>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "address.h"
#include "bound_socket.h"
#include "tandem/nats/hub.h"

namespace tandem::nats {

/// A UDP socket for all peers of a process, beside their connection to the server. It lets packets
/// of connections through and no handshakes: who meets whom is said over the server.
/// @par Thread safety  Any thread.
class DirectSocket {
 public:
  /// Hears what comes, on the socket's thread; does not wait.
  using Hear = std::function<void(std::span<const std::byte> datagram, const net::Address& from)>;

  /// Throws std::system_error where it cannot bind.
  explicit DirectSocket(const DirectOptions& options);
  ~DirectSocket();
  DirectSocket(const DirectSocket&) = delete;
  DirectSocket& operator=(const DirectSocket&) = delete;

  /// What has a receiver number with this upper half, for as long as `hear` lives, and perhaps once
  /// more at that time.
  void attach(std::uint16_t prefix, const std::shared_ptr<Hear>& hear);
  /// May be lost.
  void send(std::span<const std::byte> datagram, const net::Address& to);
  std::uint16_t port() const { return socket_.port(); }
  /// Datagrams that nobody here has heard.
  std::uint64_t unknown() const { return unknown_; }
  /// Where others reach it, as far as is known here.
  const std::vector<net::Address>& addresses() const { return addresses_; }

 private:
  void run();
  void deliver(std::span<const std::byte> datagram, const net::Address& from);

  asio::io_context context_{1};
  net::BoundSocket socket_;
  std::vector<net::Address> addresses_;
  std::mutex mutex_;  ///< of who hears
  std::vector<std::pair<std::uint16_t, std::weak_ptr<Hear>>> heard_by_;
  std::atomic<std::uint64_t> unknown_ = 0;
  std::array<int, 2> wake_{-1, -1};  ///< a pipe: after a word in it the thread ends
  std::thread thread_;
};

}  // namespace tandem::nats
