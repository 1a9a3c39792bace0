// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstdio>

#include "tandem/net/tcp.h"

// Opens a peer that listens on loopback, and closes it.
int main() {
  tandem::net::TcpOptions options;
  options.self = 1;
  options.listen_port = 0;
  options.listen_address = "127.0.0.1";
  const tandem::net::TcpTransport transport(options);
  std::printf("net: peer %llu listens on port %u\n",
              static_cast<unsigned long long>(transport.self()),
              static_cast<unsigned>(transport.local_port()));
  return transport.local_port() != 0 && transport.peers().empty() ? 0 : 1;
}
