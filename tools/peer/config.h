// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "peer/log.h"
#include "session/options.h"
#include "tandem/net/session.h"

namespace tandem::demos {

/// Configuration of a long-running peer; docs/tandem-peer.md lists the keys.
struct PeerConfig {
  /// Id, seed, rates and network; the rest are defaults.
  DemoOptions session;
  std::string group_file;  ///< with an organiser's GroupChange; "" = none
  /// Files for meeting others by ICE: own (written) and the other's (read).
  std::vector<std::pair<std::string, std::string>> meetings;
  struct Turn {
    net::HostPort address;
    std::string user;
    std::string password;
  };
  std::optional<net::HostPort> stun;
  std::optional<Turn> turn;
  bool fidget = false;                        ///< adds a scripted user
  std::uint64_t user_seed = 0;                ///< seed of that user; 0 = from seed and id
  std::string log_file;                       ///< "" = standard error
  Level log_level = Level::Info;              ///< lowest level written
  bool status_line = true;                    ///< if standard error is a terminal
  std::optional<std::uint16_t> metrics_port;  ///< 0 takes a free one; none: no metrics
  std::string metrics_address = "127.0.0.1";  ///< numeric
};

/// An invalid file; what() names file, line, key, value and rule.
class ConfigError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Derives a missing id from this peer's key, which is created and stored if missing. Nobody else
/// can have it. @throws ConfigError
void derive_id(PeerConfig& config);

/// Reads a file. File names in it are relative to its folder.
/// @param transport  replaces the file's network.transport; "" = no replacement  @throws
/// ConfigError
PeerConfig read_config(const std::string& path, const std::string& transport = {});
/// The same from its text. @param name  of the file, for errors and relative names
PeerConfig parse_config(std::string_view text, const std::string& name,
                        const std::string& transport = {});

}  // namespace tandem::demos
