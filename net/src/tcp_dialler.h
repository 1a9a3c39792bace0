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

/// Which addresses to dial and when, and the looking up and connecting. Network thread only.
class TcpDialler {
 public:
  struct Hooks {
    /// A new link, of the dial with this number.
    std::function<std::shared_ptr<TcpLink>(std::uint64_t dial)> open;
    std::function<void(TcpLink&)> connected;
  };

  /// @param anywhere  addresses of other machines may be dialled
  TcpDialler(asio::io_context& context, const TcpOptions& options, bool anywhere,
             const PeerTable& table, TcpReport& report, Hooks hooks);

  /// Dials what is due.
  void sweep(SteadyTime now);
  /// A dial has ended without a peer, or its link is gone.
  void on_failure(std::uint64_t serial, const std::string& reason);
  /// The connection of a peer has ended: back-off starts over if that had lasted for a while.
  void redial(PeerId peer, bool lasted);
  /// A peer says that it listens on that port of the host that it came from.
  /// @param serial  of the dial that has led to it; 0: none     @param address  port 0: nowhere
  void learn(std::uint64_t serial, PeerId peer, const HostPort& address);
  /// What a peer says of others. Hearsay adds addresses and replaces none.
  void hear(std::span<const PeerAddress> addresses, const asio::ip::address& teller);
  /// This process itself is there.
  void note_self(std::uint64_t serial);
  /// How often it was dialled before this time.
  std::uint64_t attempts_before(std::uint64_t serial) const;
  void publish();
  void clear() { dials_.clear(); }
  void cancel() { resolver_.cancel(); }

 private:
  using Endpoint = asio::ip::tcp::endpoint;

  /// An address to dial: given by the application, told by the peer itself, or by another one.
  struct Dial {
    std::uint64_t serial = 0;
    HostPort address;
    bool lasting = false;  // not hearsay only, which is forgotten after some failures
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
