// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/member_socket.h"
#include "server/page_files.h"

namespace tandem::room {

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< numeric
  std::uint16_t port = 0;             ///< 0 takes a free one
  std::string token;                  ///< 32 hex digits; "" generates them
  /// Host and port of a proxy in front: "play.example.org". "": none
  std::string name;
  std::vector<std::string> rooms = {"sandbox", "piano", "tennis"};
  std::size_t max_members = 8;       ///< of a room
  std::size_t max_connections = 96;  ///< of any kind
  std::size_t max_per_address = 48;  ///< the same for one remote address
  MemberLimits member;
};

/// Serves a room's page, announces members to each other and relays their sealed messages, without
/// the room's key. Runs on its own thread.
/// @par Thread safety  Safe: all methods from any thread.
class RoomServer {
 public:
  /// @throws std::invalid_argument naming field, value and rule; std::runtime_error if it cannot
  /// listen
  RoomServer(const ServerOptions& options, PageFiles files);
  ~RoomServer();
  RoomServer(const RoomServer&) = delete;
  RoomServer& operator=(const RoomServer&) = delete;

  std::uint16_t port() const;
  /// Without the key.
  std::string url() const;

  struct Counters {
    std::uint64_t relayed = 0;    ///< messages taken to be relayed
    std::uint64_t dropped = 0;    ///< because a member was slow
    std::uint64_t refused = 0;    ///< requests and connections
    std::size_t members = 0;      ///< now
    std::size_t connections = 0;  ///< now
  };
  Counters counters() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::room
