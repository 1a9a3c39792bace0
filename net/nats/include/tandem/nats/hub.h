// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tandem/net/session.h"
#include "tandem/pbd/export.h"

namespace tandem::nats {

/// A UDP socket beside the connection to the server, by which near peers communicate directly.
struct TANDEM_API DirectOptions {
  std::string listen_address = "0.0.0.0";  ///< numeric, of this machine
  std::uint16_t listen_port = 0;           ///< 0 = a free one
  /// Public addresses of the socket, numeric, at most four; empty: the addresses of this machine.
  /// Only the NatsOptions::direct_peers nearest receive them, sealed.
  std::vector<net::HostPort> reachable_at = {};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Address of the server, and credentials of this process.
struct TANDEM_API HubOptions {
  std::vector<net::HostPort> servers = {};  ///< of one cluster, at least one; tried in turn
  std::string user = {};                    ///< empty: no user name and no password
  std::string password = {};
  bool tls = false;  ///< the server needs a certificate that this system trusts
  std::chrono::milliseconds reconnect_wait{100};  ///< between two attempts, in [10 ms, 1 min]
  /// None: all packets go through the server.
  std::optional<DirectOptions> direct = {};
  /// Whether a thread of the hub's drives the transports; false: NatsTransport::poll() does.
  bool driven = true;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

struct TANDEM_API HubStatus {
  bool connected = false;
  std::uint16_t direct_port = 0;     ///< bound by HubOptions::direct; 0: none
  std::uint64_t direct_unknown = 0;  ///< datagrams there that are for no transport here
  std::uint64_t reconnects = 0;
  std::uint64_t messages_in = 0;
  std::uint64_t messages_out = 0;
  std::uint64_t bytes_in = 0;   ///< of payloads
  std::uint64_t bytes_out = 0;  ///< of payloads
  std::uint64_t lost = 0;       ///< not sent, as there was no server
  std::uint64_t slow = 0;       ///< times that messages were dropped for slowness
  std::size_t waiting = 0;      ///< requests of ledgers and events not done; retried
  std::string reason = {};      ///< last failure of a connected server, and why
};

/// A connection to a NATS server, for any number of transports of this process. It connects by
/// itself, and reconnects without a limit.
/// @par Thread safety  Any thread.
class TANDEM_API NatsHub {
 public:
  /// A server that is unreachable (yet) is no error. @throws std::invalid_argument
  /// (HubOptions::validate), std::runtime_error if the client library cannot start,
  /// std::system_error if HubOptions::direct cannot be bound
  explicit NatsHub(const HubOptions& options);
  ~NatsHub();
  NatsHub(const NatsHub&) = delete;
  NatsHub& operator=(const NatsHub&) = delete;

  HubStatus status() const;

  class Impl;
  /// For this library.
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::nats
