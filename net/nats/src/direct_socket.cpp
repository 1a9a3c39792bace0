// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "direct_socket.h"

#include <fcntl.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <asio/ip/address.hpp>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "datagram_batch.h"
#include "direct_way.h"
#include "loopback.h"
#include "packet_protection.h"

namespace tandem::nats {

namespace {

net::UdpOptions bound_by(const DirectOptions& options) {
  net::UdpOptions out;
  out.listen_address = options.listen_address;
  out.listen_port = options.listen_port;
  return out;
}

/// Addresses of this machine's interfaces; the loopback's if there are no others.
std::vector<asio::ip::address> own_addresses(bool with_v6) {
  std::vector<asio::ip::address> out;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return out;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owned(list, freeifaddrs);
  for (const ifaddrs* each = list; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || (each->ifa_flags & IFF_UP) == 0) continue;
    if (each->ifa_addr->sa_family == AF_INET) {
      sockaddr_in address{};
      std::memcpy(&address, each->ifa_addr, sizeof address);
      out.emplace_back(asio::ip::address_v4(ntohl(address.sin_addr.s_addr)));
    } else if (with_v6 && each->ifa_addr->sa_family == AF_INET6) {
      sockaddr_in6 address{};
      std::memcpy(&address, each->ifa_addr, sizeof address);
      asio::ip::address_v6::bytes_type bytes{};
      std::memcpy(bytes.data(), &address.sin6_addr, bytes.size());
      if (const asio::ip::address_v6 v6(bytes); !v6.is_link_local()) out.emplace_back(v6);
    }
  }
  const auto is_loopback = [](const asio::ip::address& ip) { return ip.is_loopback(); };
  if (!std::ranges::all_of(out, is_loopback)) std::erase_if(out, is_loopback);
  return out;
}

std::vector<net::Address> addresses_of(const DirectOptions& options, std::uint16_t port) {
  std::vector<net::Address> out;
  for (const net::HostPort& each : options.reachable_at) {
    out.push_back({net::to_bytes(asio::ip::make_address(each.host)), each.port});
  }
  const auto bound = asio::ip::make_address(options.listen_address);
  if (out.empty() && !bound.is_unspecified()) out.push_back({net::to_bytes(bound), port});
  if (out.empty()) {
    for (const auto& ip : own_addresses(bound.is_v6())) out.push_back({net::to_bytes(ip), port});
  }
  if (out.size() > net::DirectWay::kMaxOffered) out.resize(net::DirectWay::kMaxOffered);
  return out;
}

}  // namespace

DirectSocket::DirectSocket(const DirectOptions& options)
    : socket_(context_, bound_by(options)), addresses_(addresses_of(options, socket_.port())) {
  if (pipe2(wake_.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::system_category(), "DirectSocket: cannot make a pipe");
  }
  thread_ = std::thread([this] { run(); });
}

DirectSocket::~DirectSocket() {
  const char end = 0;
  // The pipe always has room for one byte.
  (void)!write(wake_[1], &end, 1);
  thread_.join();
  close(wake_[1]);
  close(wake_[0]);
}

void DirectSocket::attach(std::uint16_t prefix, const std::shared_ptr<Hear>& hear) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(heard_by_, [](const auto& entry) { return entry.second.expired(); });
  heard_by_.emplace_back(prefix, hear);
}

void DirectSocket::send(std::span<const std::byte> datagram, const net::Address& to) {
  socket_.send(datagram, to);
}

void DirectSocket::run() {
  net::DatagramBatch batch;
  const net::NativeSocket socket = socket_.socket().native_handle();
  std::array<pollfd, 2> waits{{{socket, POLLIN, 0}, {wake_[0], POLLIN, 0}}};
  for (;;) {
    if (poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) return;
    if (waits[1].revents != 0) return;
    if (batch.read(socket) != net::DatagramBatch::Read::Some) continue;
    for (std::size_t i = 0; i < batch.size(); ++i) deliver(batch.bytes(i), batch.from(i));
  }
}

void DirectSocket::deliver(std::span<const std::byte> datagram, const net::Address& from) {
  bool heard = false;
  if (const auto header = net::decode_protected_header(datagram)) {
    const std::scoped_lock lock(mutex_);
    for (const auto& [prefix, hears] : heard_by_) {
      const auto hear = prefix == header->receiver >> 16 ? hears.lock() : nullptr;
      if (hear == nullptr) continue;
      (*hear)(datagram, from);
      heard = true;
    }
  }
  if (!heard) ++unknown_;
}

}  // namespace tandem::nats
