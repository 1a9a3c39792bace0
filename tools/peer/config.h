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

/// What a long-running peer reads from its file; docs/tandem-peer.md lists the keys.
struct PeerConfig {
  /// Its id, seed, rates and place on the network; the rest as everywhere.
  DemoOptions session;
  std::string group_file;  ///< with an organiser's GroupChange; "" = none
  /// Files with which others are met by ICE: the one that is written, and the other's.
  std::vector<std::pair<std::string, std::string>> meetings;
  struct Turn {
    net::HostPort address;
    std::string user;
    std::string password;
  };
  std::optional<net::HostPort> stun;
  std::optional<Turn> turn;
  bool fidget = false;                        ///< a scripted user sits here
  std::uint64_t user_seed = 0;                ///< of that user; 0 = from seed and id
  std::string log_file;                       ///< "" = standard error
  Level log_level = Level::Info;              ///< the least that is written
  bool status_line = true;                    ///< where standard error is a terminal
  std::optional<std::uint16_t> metrics_port;  ///< 0 takes a free one; none: nothing is served
  std::string metrics_address = "127.0.0.1";  ///< numeric
};

/// A file that cannot be used; what() names file, line, key, value and rule.
class ConfigError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Where the file gives no id: the one that follows from this peer's key, which is made and kept
/// where there is none yet. Nobody else can have it. @throws ConfigError
void derive_id(PeerConfig& config);

/// Reads a file. Names of files in it are relative to its folder.
/// @param transport  in place of the file's network.transport; "" = as that says  @throws
/// ConfigError
PeerConfig read_config(const std::string& path, const std::string& transport = {});
/// The same from its text. @param name  of the file, for errors and relative names
PeerConfig parse_config(std::string_view text, const std::string& name,
                        const std::string& transport = {});

}  // namespace tandem::demos
