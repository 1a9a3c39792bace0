// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/net/datagram_path.h"
#include "tandem/net/session.h"
#include "tandem/pbd/export.h"

namespace tandem::ice {

/// A server that passes datagrams on where two NATs let nothing else through (RFC 8656), over UDP.
struct TANDEM_API TurnServer {
  net::HostPort address = {};
  std::string user = {};
  std::string password = {};
};

/// Who helps two peers behind NATs to find each other. Names are looked up once, at the start, and
/// that waits. None of these servers reads anything, and none is trusted.
struct TANDEM_API IceOptions {
  std::vector<net::HostPort> stun = {};  ///< at most one: tells this peer how it is seen (RFC 8489)
  std::vector<TurnServer> turn = {};
  std::string address = {};  ///< numeric, use this one of the host alone; empty: all
  bool relay_only = false;   ///< through TURN alone: the peer does not learn this host's addresses

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// A way between two peers found by ICE (RFC 8445), on libnice. Each of the two makes one, brings
/// its description() to the other one however it likes, and gives connect() what it has got; which
/// of them does so first is all the same. Then UdpTransport::connect() takes it, at any time.
///
/// It is for one other peer and one meeting: where it has Failed, both make a new one.
/// @par Thread safety  One object: any thread.
class TANDEM_API IcePath final : public net::DatagramPath {
 public:
  /// Begins to gather addresses, on a thread of its own.
  /// @throws std::invalid_argument (IceOptions::validate), std::runtime_error that says what cannot
  /// be looked up or had
  explicit IcePath(const IceOptions& options);
  ~IcePath() override;
  IcePath(const IcePath&) = delete;
  IcePath& operator=(const IcePath&) = delete;

  enum class State : std::uint8_t { Gathering, Ready, Connecting, Connected, Failed };
  State state() const;
  /// Lines of text for the other peer, empty while Gathering. It has this host's addresses, and a
  /// password for the checks of this one meeting: who has it can disturb that, and nothing more.
  std::string description() const;
  /// @param remote  the other peer's description(). Once, and not while Gathering
  /// @throws std::invalid_argument that says what is wrong with it
  void connect(std::string_view remote);
  /// How it goes there, for people: "host to srflx" and the like; empty where not Connected.
  std::string route() const;

  void send(std::span<const std::byte> datagram) override;
  void receive(Receive receive) override;
  /// 1472 on a way straight to the other host where this system can be told to cut nothing into
  /// pieces; 1200 through a TURN server, which may.
  std::size_t max_datagram() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// "gathering" and so on.
TANDEM_API std::string_view to_string(IcePath::State state);

}  // namespace tandem::ice
