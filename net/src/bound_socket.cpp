// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "bound_socket.h"

#include <asio/buffer.hpp>
#include <asio/ip/v6_only.hpp>

#include "datagram_batch.h"
#include "own_port.h"
#include "socket_error.h"

namespace tandem::net {

namespace {

constexpr int kSocketBuffer = 512 * 1024;  // bytes

}  // namespace

BoundSocket::BoundSocket(asio::io_context& context, const UdpOptions& options) : socket_(context) {
  std::error_code error;
  const auto address = asio::ip::make_address(options.listen_address, error);
  is_v6_ = address.is_v6();
  const Endpoint endpoint(address, options.listen_port);
  if (!error) socket_.open(endpoint.protocol(), error);
  if (!error && is_v6_) socket_.set_option(asio::ip::v6_only(false), error);
#ifdef _WIN32  // elsewhere two UDP sockets share a port only if both ask for it
  if (!error) socket_.set_option(OwnPort(true), error);
#endif
  if (!error) socket_.bind(endpoint, error);
  if (!error) socket_.non_blocking(true, error);
  if (!error) port_ = socket_.local_endpoint(error).port();
  if (error) {
    throw socket_error(error, "UdpTransport: cannot bind " +
                                  to_string(HostPort{options.listen_address, options.listen_port}));
  }
  // Without these sizes packets are lost in bursts, nothing else.
  socket_.set_option(asio::socket_base::receive_buffer_size(kSocketBuffer), error);
  socket_.set_option(asio::socket_base::send_buffer_size(kSocketBuffer), error);
  forbids_fragments_ = forbid_fragments(socket_.native_handle());
}

void BoundSocket::send(std::span<const std::byte> datagram, const Address& to) {
  const asio::ip::address_v6 ip(to.ip);
  Endpoint endpoint(ip, to.port);
  if (!is_v6_) {
    // Its sender has IPv6; a relay may reach it.
    if (!is_v4(to)) return;
    endpoint = {asio::ip::make_address_v4(asio::ip::v4_mapped, ip), to.port};
  }
  // Full buffer or lost route: the packet is lost.
  std::error_code ignored;
  socket_.send_to(asio::buffer(datagram.data(), datagram.size()), endpoint, 0, ignored);
}

}  // namespace tandem::net
