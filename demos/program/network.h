// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "session/options.h"
#include "session/session_key.h"
#include "tandem/consensus/transport.h"

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
  /// ns: by how much the system clock was set since the start, where session time began with it.
  virtual std::int64_t clock_stepped() const { return 0; }
};

/// As the options say.
/// @throws std::invalid_argument, std::system_error where it cannot be had, with the reason
std::unique_ptr<Network> make_network(const DemoOptions& options, std::uint64_t scene_hash);

/// The key in a file that the options name.
/// @throws std::invalid_argument that says what the file must be
Key read_key(const std::string& path);

// The kinds that there are.
std::unique_ptr<Network> make_tcp_network(const DemoOptions& options, std::uint64_t scene_hash);
std::unique_ptr<Network> make_udp_network(const DemoOptions& options, std::uint64_t scene_hash);

}  // namespace tandem::demos
