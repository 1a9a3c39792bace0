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

/// Datagrams read from a non-blocking socket: many per call if the system can (recvmmsg), otherwise
/// one.
class DatagramBatch {
 public:
  static constexpr std::size_t kCount = 64;
  static constexpr std::size_t kBytes = 1500;  // of each; longer ones are invalid

  DatagramBatch();
  ~DatagramBatch();
  DatagramBatch(const DatagramBatch&) = delete;
  DatagramBatch& operator=(const DatagramBatch&) = delete;

  enum class Read { Some, Nothing, Error };  // Error: of an earlier send; read on
  Read read(NativeSocket socket);

  std::size_t size() const;
  std::span<const std::byte> bytes(std::size_t index) const;
  Address from(std::size_t index) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Forbids fragmentation of sent datagrams, and ignores the kernel's path MTU. False if it cannot:
/// then the path MTU cannot be found.
bool forbid_fragments(NativeSocket socket);

/// Lets the kernel drop datagrams that are not for this socket: neither a handshake by its first
/// bytes nor a packet for a receiver number with this `prefix` (upper half). False if the kernel
/// cannot; then they are dropped here.
bool attach_filter(NativeSocket socket, std::uint16_t prefix);

}  // namespace tandem::net
