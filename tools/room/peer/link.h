// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cipher/cipher.h"
#include "server/wire.h"

namespace tandem::room {

/// The parts of a room's link, http://HOST[:PORT]/TOKEN/?room=NAME#KEY.
struct Address {
  std::string host;
  std::string port;
  std::string token;
  std::string room;
  Bytes key;
};
/// @throws std::invalid_argument naming the part and the rule
Address read_address(std::string_view link);

/// A member's WebSocket to the room's server, on its own thread, with reconnection.
/// @par Thread safety  Safe: all methods from any thread.
class Link {
 public:
  Link(const Address& address, MemberId self);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// False if it is not connected, or the queue is full.
  bool send(Bytes message);
  /// Appends received messages. An empty one means a new connection.
  void take(std::vector<Bytes>& out);
  bool connected() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::room
