// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "address.h"

namespace tandem::net {

#ifdef _WIN32
using NativeSocket = std::uintptr_t;  // SOCKET
#else
using NativeSocket = int;
#endif

/// Datagrams read from a socket that does not block, many with one call where the system can
/// (recvmmsg), one with each elsewhere.
class DatagramBatch {
 public:
  static constexpr std::size_t kCount = 64;
  static constexpr std::size_t kBytes = 1500;  // of each; longer ones are cut, and too long anyway

  DatagramBatch();
  ~DatagramBatch();
  DatagramBatch(const DatagramBatch&) = delete;
  DatagramBatch& operator=(const DatagramBatch&) = delete;

  enum class Read { Some, Nothing, Error };  // Error: of something that was sent; read on
  Read read(NativeSocket socket);

  std::size_t size() const;
  std::span<const std::byte> bytes(std::size_t index) const;
  Address from(std::size_t index) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Makes datagrams leave in one piece or not at all, whatever the kernel believes of the way. False
/// where it cannot: then their longest length cannot be found out.
bool forbid_fragments(NativeSocket socket);

/// Lets the kernel drop, before it wakes anybody, what cannot be for this socket: neither a
/// handshake by its first bytes nor a packet for a receiver number of this `prefix` (its upper
/// half). False where the kernel cannot; then they are dropped here.
bool attach_filter(NativeSocket socket, std::uint16_t prefix);

}  // namespace tandem::net
