// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "datagram_batch.h"

#ifdef _WIN32
#include <winsock2.h>
#include <ws2tcpip.h>
#else
#include <netinet/in.h>
#include <sys/socket.h>
#endif
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
  Impl();
  Read read(NativeSocket socket);

  std::size_t count = 0;
  std::array<std::size_t, kCount> lengths{};  ///< bytes
  std::array<sockaddr_storage, kCount> names{};
  std::array<std::array<std::byte, kBytes>, kCount> memory{};

 private:
  Read read_each(NativeSocket socket);
#ifdef __linux__
  bool many_ = true;
  std::array<mmsghdr, kCount> messages_{};
  std::array<iovec, kCount> parts_{};
#endif
};

DatagramBatch::Impl::Impl() {
#ifdef __linux__
  for (std::size_t i = 0; i < kCount; ++i) {
    parts_[i] = {.iov_base = memory[i].data(), .iov_len = kBytes};
    msghdr& header = messages_[i].msg_hdr;
    header.msg_name = &names[i];
    header.msg_iov = &parts_[i];
    header.msg_iovlen = 1;
  }
#endif
}

DatagramBatch::Read DatagramBatch::Impl::read(NativeSocket socket) {
  count = 0;
#ifdef __linux__
  if (many_) {
    for (mmsghdr& message : messages_) message.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    const int got = ::recvmmsg(socket, messages_.data(), kCount, MSG_DONTWAIT, nullptr);
    if (got >= 0) {
      count = static_cast<std::size_t>(got);
      for (std::size_t i = 0; i < count; ++i) lengths[i] = messages_[i].msg_len;
      return count > 0 ? Read::Some : Read::Nothing;
    }
    if (errno == EAGAIN || errno == EWOULDBLOCK) return Read::Nothing;
    if (errno != ENOSYS) return Read::Error;
    many_ = false;
  }
#endif
  return read_each(socket);
}

DatagramBatch::Read DatagramBatch::Impl::read_each(NativeSocket socket) {
  for (count = 0; count < kCount; ++count) {
    socklen_t name_length = sizeof names[count];
    const auto got = ::recvfrom(socket, reinterpret_cast<char*>(memory[count].data()), kBytes, 0,
                                reinterpret_cast<sockaddr*>(&names[count]), &name_length);
    if (got < 0) break;
    lengths[count] = static_cast<std::size_t>(got);
  }
  if (count > 0) return Read::Some;
#ifdef _WIN32
  return ::WSAGetLastError() == WSAEWOULDBLOCK ? Read::Nothing : Read::Error;
#else
  return errno == EAGAIN || errno == EWOULDBLOCK ? Read::Nothing : Read::Error;
#endif
}

DatagramBatch::DatagramBatch() : impl_(std::make_unique<Impl>()) {}
DatagramBatch::~DatagramBatch() = default;

DatagramBatch::Read DatagramBatch::read(NativeSocket socket) { return impl_->read(socket); }

std::size_t DatagramBatch::size() const { return impl_->count; }

std::span<const std::byte> DatagramBatch::bytes(std::size_t index) const {
  return std::span(impl_->memory[index]).first(impl_->lengths[index]);
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

bool forbid_fragments(NativeSocket socket) {
  const auto set = [&](int level, int name, int value) {
    return ::setsockopt(socket, level, name, reinterpret_cast<const char*>(&value), sizeof value) ==
           0;
  };
  // An IPv6 socket also sends to IPv4.
#if defined(__linux__)
  (void)set(IPPROTO_IPV6, IPV6_MTU_DISCOVER, IPV6_PMTUDISC_PROBE);
  return set(IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_PROBE);
#elif defined(_WIN32)
  (void)set(IPPROTO_IPV6, IPV6_DONTFRAG, 1);
  return set(IPPROTO_IP, IP_DONTFRAGMENT, 1);
#elif defined(IP_DONTFRAG)
  return set(IPPROTO_IP, IP_DONTFRAG, 1);
#else
  static_cast<void>(set);
  return false;
#endif
}

bool attach_filter(NativeSocket socket, std::uint16_t prefix) {
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
      {BPF_RET | BPF_K, 0, 0, 0xffff},  // accept
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
