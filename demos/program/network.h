// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "session/options.h"
#include "session/session_key.h"
#include "tandem/consensus/transport.h"
#include "tandem/net/datagram_path.h"
#include "tandem/net/keys.h"

namespace tandem::demos {

/// A process's place on a real network, and its shared session time.
class Network {
 public:
  virtual ~Network() = default;
  virtual consensus::Transport& transport() = 0;
  /// Session time, ns.
  virtual consensus::SessionTime now() = 0;
  /// ns: bound on the error of now(); -1 = not known.
  virtual std::int64_t clock_error() const = 0;
  virtual std::uint16_t local_port() const = 0;
  /// Why nobody has connected; "" if unknown.
  virtual std::string trouble() const = 0;
  /// How often input from unknown senders was refused, by reason.
  using Counts = std::vector<std::pair<const char*, std::uint64_t>>;
  virtual Counts refused() const = 0;
  /// Identifies this peer's public key; "" without keys.
  std::string fingerprint() const { return fingerprint_; }
  /// A change signed by an organiser, for all members, see net::GroupChange.
  virtual void change_group(std::span<const std::byte> signed_change) = 0;
  /// Number of the change in force; 0: none.
  virtual std::uint64_t group() const = 0;
  /// Adds another path to peers, see net::UdpTransport::connect.
  /// @throws std::runtime_error over TCP
  virtual void connect(std::shared_ptr<net::DatagramPath> path) = 0;
  /// ns: how far the system clock was set since the start, if session time began with it.
  virtual std::int64_t clock_stepped() const { return 0; }

 protected:
  std::string fingerprint_;
};

/// Makes the network of the options.
/// @throws std::invalid_argument, std::system_error with the reason
std::unique_ptr<Network> make_network(const DemoOptions& options, std::uint64_t scene_hash);

/// Reads a key from a file named by an option.
/// @throws std::invalid_argument naming the rule for the file
Key read_key(const std::string& path);

/// Sets identity and admitted members, for both transports.
/// @throws as make_network
template <class Options>
void set_members(const DemoOptions& from, Options& to) {
  to.session_key = read_key(from.key);
  try {
    if (!from.identity.empty()) to.identity = keep_identity(from.identity, net::make_key);
  } catch (const std::system_error&) {
    to.identity.reset();  // not stored there: a new one at each start
  }
  for (const auto& [peer, key] : from.trusted) to.trusted.push_back({peer, key});
  to.organiser = from.organiser;
  if (!from.certificate.empty()) to.certificate = read_hex_file(from.certificate);
}

std::unique_ptr<Network> make_tcp_network(const DemoOptions& options, std::uint64_t scene_hash);
std::unique_ptr<Network> make_udp_network(const DemoOptions& options, std::uint64_t scene_hash);
std::unique_ptr<Network> make_nats_network(const DemoOptions& options, std::uint64_t scene_hash);

}  // namespace tandem::demos
