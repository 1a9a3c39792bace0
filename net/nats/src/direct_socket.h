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

/// A UDP socket for all peers of a process, beside their connection to the server. It accepts
/// packets of connections, but no handshakes: these go over the server.
/// @par Thread safety  Any thread.
class DirectSocket {
 public:
  /// Called with a datagram, on the socket's thread; must not block.
  using Hear = std::function<void(std::span<const std::byte> datagram, const net::Address& from)>;

  /// Throws std::system_error if it cannot bind.
  explicit DirectSocket(const DirectOptions& options);
  ~DirectSocket();
  DirectSocket(const DirectSocket&) = delete;
  DirectSocket& operator=(const DirectSocket&) = delete;

  /// Receive packets whose receiver number has this upper half, for the lifetime of `hear`, and
  /// perhaps once more at its end.
  void attach(std::uint16_t prefix, const std::shared_ptr<Hear>& hear);
  /// The datagram may be lost.
  void send(std::span<const std::byte> datagram, const net::Address& to);
  std::uint16_t port() const { return socket_.port(); }
  /// Datagrams without a receiver here.
  std::uint64_t unknown() const { return unknown_; }
  /// Public addresses, as far as known here.
  const std::vector<net::Address>& addresses() const { return addresses_; }

 private:
  void run();
  void deliver(std::span<const std::byte> datagram, const net::Address& from);

  asio::io_context context_{1};
  net::BoundSocket socket_;
  std::vector<net::Address> addresses_;
  std::mutex mutex_;  ///< of heard_by_
  std::vector<std::pair<std::uint16_t, std::weak_ptr<Hear>>> heard_by_;
  std::atomic<std::uint64_t> unknown_ = 0;
  std::array<int, 2> wake_{-1, -1};  ///< a pipe: a byte in it ends the thread
  std::thread thread_;
};

}  // namespace tandem::nats
