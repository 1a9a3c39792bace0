// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "peer_table.h"
#include "tandem/net/tcp.h"
#include "tandem/pbd/random.h"
#include "tcp_link.h"
#include "tcp_report.h"
#include "wire.h"

namespace tandem::net {

/// Which addresses to dial and when; look-ups and connecting. Network thread only.
class TcpDialler {
 public:
  struct Hooks {
    /// A new link, for the dial with this number.
    std::function<std::shared_ptr<TcpLink>(std::uint64_t dial)> open;
    std::function<void(TcpLink&)> connected;
  };

  /// @param anywhere  whether addresses of other hosts may be dialled
  TcpDialler(asio::io_context& context, const TcpOptions& options, bool anywhere,
             const PeerTable& table, TcpReport& report, Hooks hooks);

  /// Dials the addresses that are due.
  void sweep(SteadyTime now);
  /// A dial has failed, or its link is closed.
  void on_failure(std::uint64_t serial, const std::string& reason);
  /// The connection of a peer has ended: back-off starts over if it had lasted for a while.
  void redial(PeerId peer, bool lasted);
  /// A peer announces the port on which it listens, on the host that it came from.
  /// @param serial  of the dial that led to it; 0: none     @param address  port 0: none
  void learn(std::uint64_t serial, PeerId peer, const HostPort& address);
  /// A peer's addresses of other peers. Hearsay adds addresses and replaces none.
  void hear(std::span<const PeerAddress> addresses, const asio::ip::address& teller);
  /// The address is that of this process.
  void note_self(std::uint64_t serial);
  /// Number of earlier dials.
  std::uint64_t attempts_before(std::uint64_t serial) const;
  void publish();
  void clear() { dials_.clear(); }
  void cancel() { resolver_.cancel(); }

 private:
  using Endpoint = asio::ip::tcp::endpoint;

  /// An address to dial: given by the application, announced by the peer itself, or by another one.
  struct Dial {
    std::uint64_t serial = 0;
    HostPort address;
    bool lasting = false;  // false: hearsay only, dropped after some failures
    PeerId peer = 0;
    bool is_self = false;
    bool busy = false;  // looking up, connecting or shaking hands
    std::uint64_t attempts = 0;
    SteadyTime due{};
    std::string reason;
  };

  void add(const HostPort& address, PeerId peer, bool lasting, SteadyTime due);
  bool may_dial(const Dial& dial) const;
  bool may_reach(const asio::ip::address& address) const;
  void start(Dial& dial);
  void look_up(const Dial& dial);
  void connect(const Dial& dial, const std::vector<Endpoint>& endpoints);
  SteadyTime::duration backoff(std::uint64_t attempts);
  Dial* find(std::uint64_t serial);

  const TcpOptions& options_;
  bool anywhere_;
  const PeerTable& table_;
  TcpReport& report_;
  Hooks hooks_;
  asio::ip::tcp::resolver resolver_;
  std::vector<Dial> dials_;
  std::uint64_t next_serial_ = 1;
  pbd::SplitMix64 jitter_;
};

}  // namespace tandem::net
