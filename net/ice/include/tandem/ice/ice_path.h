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

/// A relay for peers whose NATs let nothing else through (RFC 8656), over UDP.
struct TANDEM_API TurnServer {
  net::HostPort address = {};
  std::string user = {};
  std::string password = {};
};

/// Servers that help two peers behind NATs to connect. Names are looked up once, at the start,
/// which blocks. None of these servers can read the traffic, and none is trusted.
struct TANDEM_API IceOptions {
  std::vector<net::HostPort> stun = {};  ///< at most one: reports the public address (RFC 8489)
  std::vector<TurnServer> turn = {};
  std::string address = {};  ///< numeric, the only address of this host to use; empty: all
  bool relay_only = false;   ///< TURN only: the peer does not learn this host's addresses

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// A path between two peers found by ICE (RFC 8445), on libnice. Each of the two makes one, sends
/// its description() to the other by any means, and gives connect() the one it has received, in
/// either order. UdpTransport::connect() takes the path at any time.
///
/// It serves one peer and one meeting: once it has Failed, both make a new one.
/// @par Thread safety  One object: any thread.
class TANDEM_API IcePath final : public net::DatagramPath {
 public:
  /// Starts to gather addresses, on its own thread.
  /// @throws std::invalid_argument (IceOptions::validate), std::runtime_error that says what cannot
  /// be looked up or created
  explicit IcePath(const IceOptions& options);
  ~IcePath() override;
  IcePath(const IcePath&) = delete;
  IcePath& operator=(const IcePath&) = delete;

  enum class State : std::uint8_t { Gathering, Ready, Connecting, Connected, Failed };
  State state() const;
  /// Lines of text for the other peer, empty while Gathering. They contain this host's addresses
  /// and a password for the connectivity checks of this meeting: a third party that has it can only
  /// disturb them.
  std::string description() const;
  /// @param remote  the other peer's description(). Call it once, and not while Gathering
  /// @throws std::invalid_argument that says what is wrong with it
  void connect(std::string_view remote);
  /// Kind of path, for people: "host to srflx" and the like; empty unless Connected.
  std::string route() const;

  void send(std::span<const std::byte> datagram) override;
  void receive(Receive receive) override;
  /// 1472 on a direct path if this system can forbid fragmentation; 1200 through a TURN server,
  /// which may fragment.
  std::size_t max_datagram() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// "gathering" and so on.
TANDEM_API std::string_view to_string(IcePath::State state);

}  // namespace tandem::ice
