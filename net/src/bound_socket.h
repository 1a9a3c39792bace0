// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <cstddef>
#include <cstdint>
#include <span>

#include "address.h"
#include "tandem/net/udp.h"

namespace tandem::net {

/// A non-blocking UDP socket, bound.
class BoundSocket {
 public:
  using Endpoint = asio::ip::udp::endpoint;

  /// Throws std::system_error if it cannot bind.
  BoundSocket(asio::io_context& context, const UdpOptions& options);

  asio::ip::udp::socket& socket() { return socket_; }
  std::uint16_t port() const { return port_; }
  /// Whether datagrams too long for the path are lost instead of fragmented.
  bool forbids_fragments() const { return forbids_fragments_; }
  bool reaches(const asio::ip::address& address) const { return is_v6_ || address.is_v4(); }
  /// The datagram may be lost.
  void send(std::span<const std::byte> datagram, const Address& to);

 private:
  asio::ip::udp::socket socket_;
  bool is_v6_ = false;
  bool forbids_fragments_ = false;
  std::uint16_t port_ = 0;
};

}  // namespace tandem::net
