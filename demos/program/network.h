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

/// A process's place on a real network, and the time that it shares with the others there.
class Network {
 public:
  virtual ~Network() = default;
  virtual consensus::Transport& transport() = 0;
  /// Session time, ns.
  virtual consensus::SessionTime now() = 0;
  /// ns: how far now() can be from the others'; -1 = not known.
  virtual std::int64_t clock_error() const = 0;
  virtual std::uint16_t local_port() const = 0;
  /// Why nobody has come, for who waits; "" where nothing is known.
  virtual std::string trouble() const = 0;
  /// How often what came from nobody that is known was refused, by reason.
  using Counts = std::vector<std::pair<const char*, std::uint64_t>>;
  virtual Counts refused() const = 0;
  /// Of this peer's public key; "" without keys.
  std::string fingerprint() const { return fingerprint_; }
  /// What an organiser has signed, for all members, see net::GroupChange.
  virtual void change_group(std::span<const std::byte> signed_change) = 0;
  /// Number of the change that holds; 0: none.
  virtual std::uint64_t group() const = 0;
  /// Another way on which somebody may be, see net::UdpTransport::connect.
  /// @throws std::runtime_error over TCP
  virtual void connect(std::shared_ptr<net::DatagramPath> path) = 0;
  /// ns: by how much the system clock was set since the start, where session time began with it.
  virtual std::int64_t clock_stepped() const { return 0; }

 protected:
  std::string fingerprint_;
};

/// As the options say.
/// @throws std::invalid_argument, std::system_error where it cannot be had, with the reason
std::unique_ptr<Network> make_network(const DemoOptions& options, std::uint64_t scene_hash);

/// The key in a file that the options name.
/// @throws std::invalid_argument that says what the file must be
Key read_key(const std::string& path);

/// Fill in who this peer is and whom it lets in, the same for both transports.
/// @throws as make_network
template <class Options>
void set_members(const DemoOptions& from, Options& to) {
  to.session_key = read_key(from.key);
  try {
    if (!from.identity.empty()) to.identity = keep_identity(from.identity, net::make_key);
  } catch (const std::system_error&) {
    to.identity.reset();  // nothing can be kept there: a new one at each start
  }
  for (const auto& [peer, key] : from.trusted) to.trusted.push_back({peer, key});
  to.organiser = from.organiser;
  if (!from.certificate.empty()) to.certificate = read_hex_file(from.certificate);
}

// The kinds that there are.
std::unique_ptr<Network> make_tcp_network(const DemoOptions& options, std::uint64_t scene_hash);
std::unique_ptr<Network> make_udp_network(const DemoOptions& options, std::uint64_t scene_hash);
std::unique_ptr<Network> make_nats_network(const DemoOptions& options, std::uint64_t scene_hash);

}  // namespace tandem::demos
