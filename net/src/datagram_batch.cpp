// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "datagram_batch.h"

#include <netinet/in.h>
#include <sys/socket.h>
#ifdef __linux__
#include <linux/filter.h>
#endif

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "handshake_wire.h"
#include "packet_protection.h"

namespace tandem::net {

class DatagramBatch::Impl {
 public:
  Impl() {
    for (std::size_t i = 0; i < kCount; ++i) {
      parts[i] = {.iov_base = memory[i].data(), .iov_len = memory[i].size()};
      msghdr& header = messages[i].msg_hdr;
      header = {};
      header.msg_name = &names[i];
      header.msg_iov = &parts[i];
      header.msg_iovlen = 1;
    }
  }

#ifdef __linux__
  using Message = mmsghdr;
  ssize_t read(int socket) {
    for (Message& message : messages) message.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    if (many) {
      const int got = ::recvmmsg(socket, messages.data(), kCount, MSG_DONTWAIT, nullptr);
      if (got >= 0 || errno != ENOSYS) return got;
      many = false;
    }
    return read_one(socket);
  }
  bool many = true;
#else
  struct Message {
    msghdr msg_hdr;
    unsigned int msg_len;
  };
  ssize_t read(int socket) {
    messages[0].msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    return read_one(socket);
  }
#endif
  ssize_t read_one(int socket) {
    const ssize_t got = ::recvmsg(socket, &messages[0].msg_hdr, MSG_DONTWAIT);
    if (got < 0) return got;
    messages[0].msg_len = static_cast<unsigned int>(got);
    return 1;
  }

  std::size_t count = 0;
  std::array<Message, kCount> messages{};
  std::array<iovec, kCount> parts{};
  std::array<sockaddr_storage, kCount> names{};
  std::array<std::array<std::byte, kBytes>, kCount> memory{};
};

DatagramBatch::DatagramBatch() : impl_(std::make_unique<Impl>()) {}
DatagramBatch::~DatagramBatch() = default;

DatagramBatch::Read DatagramBatch::read(int socket) {
  const ssize_t got = impl_->read(socket);
  impl_->count = got > 0 ? static_cast<std::size_t>(got) : 0;
  if (got > 0) return Read::Some;
  return got == 0 || errno == EAGAIN || errno == EWOULDBLOCK ? Read::Nothing : Read::Error;
}

std::size_t DatagramBatch::size() const { return impl_->count; }

std::span<const std::byte> DatagramBatch::bytes(std::size_t index) const {
  const std::size_t length = impl_->messages[index].msg_len;
  return std::span(impl_->memory[index]).first(std::min(length, kBytes));
}

Address DatagramBatch::from(std::size_t index) const {
  Address out;
  const sockaddr_storage& name = impl_->names[index];
  if (name.ss_family == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &name, sizeof v6);
    std::memcpy(out.ip.data(), &v6.sin6_addr, out.ip.size());
    out.port = ntohs(v6.sin6_port);
  } else {
    sockaddr_in v4{};
    std::memcpy(&v4, &name, sizeof v4);
    out.ip[10] = out.ip[11] = 0xff;
    std::memcpy(&out.ip[12], &v4.sin_addr, 4);
    out.port = ntohs(v4.sin_port);
  }
  return out;
}

bool forbid_fragments(int socket) {
#if defined(__linux__)
  // A socket for IPv6 sends to IPv4 as well.
  const int v6 = IPV6_PMTUDISC_PROBE;
  (void)::setsockopt(socket, IPPROTO_IPV6, IPV6_MTU_DISCOVER, &v6, sizeof v6);
  const int v4 = IP_PMTUDISC_PROBE;
  return ::setsockopt(socket, IPPROTO_IP, IP_MTU_DISCOVER, &v4, sizeof v4) == 0;
#elif defined(IP_DONTFRAG)
  const int on = 1;
  return ::setsockopt(socket, IPPROTO_IP, IP_DONTFRAG, &on, sizeof on) == 0;
#else
  static_cast<void>(socket);
  return false;
#endif
}

bool attach_filter(int socket, std::uint16_t prefix) {
#ifdef __linux__
  // Offsets count from the UDP header; numbers are read most significant byte first. A load beyond
  // the end drops the datagram.
  constexpr std::uint32_t kType = 8;
  constexpr std::uint32_t kMagicAt = 9;
  constexpr std::uint32_t kReceiverTop = 11;
  constexpr std::uint32_t kMagicRead = (kUdpMagic & 0xff) << 24 | (kUdpMagic >> 8 & 0xff) << 16 |
                                       (kUdpMagic >> 16 & 0xff) << 8 | kUdpMagic >> 24;
  const auto top = static_cast<std::uint32_t>((prefix & 0xff) << 8 | prefix >> 8);
  std::array<sock_filter, 10> code{{
      {BPF_LD | BPF_B | BPF_ABS, 0, 0, kType},
      {BPF_ALU | BPF_AND | BPF_K, 0, 0, 0xf0},
      {BPF_JMP | BPF_JEQ | BPF_K, 3, 0, kProtectedType},
      {BPF_JMP | BPF_JEQ | BPF_K, 2, 0, kRelayType},
      {BPF_LD | BPF_W | BPF_ABS, 0, 0, kMagicAt},
      {BPF_JMP | BPF_JEQ | BPF_K, 2, 3, kMagicRead},
      {BPF_LD | BPF_H | BPF_ABS, 0, 0, kReceiverTop},
      {BPF_JMP | BPF_JEQ | BPF_K, 0, 1, top},
      {BPF_RET | BPF_K, 0, 0, 0xffff},  // take it all
      {BPF_RET | BPF_K, 0, 0, 0},       // drop
  }};
  const sock_fprog program{.len = static_cast<unsigned short>(code.size()), .filter = code.data()};
  return ::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
#else
  static_cast<void>(socket);
  static_cast<void>(prefix);
  return false;
#endif
}

}  // namespace tandem::net
