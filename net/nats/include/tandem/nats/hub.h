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

/// A UDP socket beside the connection to the server, by which peers that are near speak to each
/// other without it.
struct TANDEM_API DirectOptions {
  std::string listen_address = "0.0.0.0";  ///< numeric, of this machine
  std::uint16_t listen_port = 0;           ///< 0 takes a free one
  /// Where others reach it, numeric, at most four; empty: at the addresses of this machine. The
  /// NatsOptions::direct_peers nearest are told, sealed, and nobody else.
  std::vector<net::HostPort> reachable_at = {};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Where the server is, and how this process shows itself there.
struct TANDEM_API HubOptions {
  std::vector<net::HostPort> servers = {};  ///< of one cluster, at least one; tried in turn
  std::string user = {};                    ///< empty: no name and no password
  std::string password = {};
  bool tls = false;  ///< the server shows a certificate that this system trusts
  std::chrono::milliseconds reconnect_wait{100};  ///< between two attempts, in [10 ms, 1 min]
  /// None: all goes over the server.
  std::optional<DirectOptions> direct = {};
  /// A thread of the hub's drives the transports; false: each is driven by NatsTransport::poll().
  bool driven = true;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

struct TANDEM_API HubStatus {
  bool connected = false;
  std::uint16_t direct_port = 0;     ///< bound by HubOptions::direct; 0: none
  std::uint64_t direct_unknown = 0;  ///< datagrams there that are for nobody here
  std::uint64_t reconnects = 0;
  std::uint64_t messages_in = 0;
  std::uint64_t messages_out = 0;
  std::uint64_t bytes_in = 0;   ///< of payloads
  std::uint64_t bytes_out = 0;  ///< likewise
  std::uint64_t lost = 0;       ///< not sent, since there was no server
  std::uint64_t slow = 0;   ///< times that the server or the client library dropped for slowness
  std::size_t waiting = 0;  ///< asked by ledgers and events and not done; tried again and again
  std::string reason = {};  ///< what a server that is there did not do last, and why
};

/// A connection to a NATS server, for any number of transports of this process. It begins on its
/// own, and again whenever it has broken, for as long as it takes.
/// @par Thread safety  Any thread.
class TANDEM_API NatsHub {
 public:
  /// A server that is not there (yet) is no error. @throws std::invalid_argument
  /// (HubOptions::validate), std::runtime_error where the client library cannot begin,
  /// std::system_error where HubOptions::direct cannot be bound
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
