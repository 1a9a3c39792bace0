// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "support/catch.h"
#include "support/sockets.h"

namespace tandem::testing {

/// A port of loopback that is free and stays so until somebody asks for it by its number: the
/// kernel hands out others, to who dials and to who takes any. One who dials a port of those where
/// nobody listens yet may even be given it, and reach himself.
/// @param kind  SOCK_STREAM or SOCK_DGRAM
inline std::uint16_t free_port(int kind = SOCK_STREAM) {
  start_sockets();
  constexpr int kFirst = 20000;  // below all that kernels hand out, above the well-known
  constexpr int kCount = 10000;
  static int next = process_id() * 37;  // tests of several processes at a time
  for (int tries = 0; tries < kCount; ++tries) {
    const auto port = static_cast<std::uint16_t>(kFirst + next++ % kCount);
    const int fd = static_cast<int>(socket(AF_INET, kind, 0));
    REQUIRE(fd >= 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    const bool is_free = bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
    close_socket(fd);
    if (is_free) return port;
  }
  FAIL("no port is free");
  return 0;
}

}  // namespace tandem::testing
