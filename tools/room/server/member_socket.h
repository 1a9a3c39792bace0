// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "page_server/access.h"
#include "page_server/page_server.h"
#include "server/wire.h"

namespace tandem::room {

class MemberSocket;
using Message = std::shared_ptr<const std::vector<std::uint8_t>>;

struct MemberLimits {
  double messages_per_s = 3000.0;
  double bytes_per_s = 6e6;
  std::size_t queue_bytes = 1 << 20;     ///< above it losable messages are dropped, oldest first
  std::size_t reliable_bytes = 4 << 20;  ///< above it the member is disconnected
};

/// Callbacks of a socket, on its thread.
class MemberHost {
 public:
  virtual ~MemberHost() = default;
  /// False if the id is taken, or the room is full.
  virtual bool join(MemberSocket& socket, std::uint64_t id) = 0;
  /// @param message  as sent, with the sender's id     @param to  0: all others
  virtual void relay(MemberSocket& socket, std::uint64_t to, Message message, bool reliable) = 0;
  virtual std::int64_t now() const = 0;  ///< ns since 1970
  virtual void dropped() = 0;
  virtual void gone(MemberSocket& socket) = 0;
};

/// One member's WebSocket. Violations of protocol or limits disconnect it.
/// @par Thread safety  One object: the thread of its socket.
class MemberSocket : public std::enable_shared_from_this<MemberSocket> {
 public:
  using Request = page_server::UpgradeRequest;

  MemberSocket(MemberHost& host, std::string room, const MemberLimits& limits,
               boost::beast::tcp_stream&& stream);

  void start(Request request);
  void send(Message message, bool reliable);
  void close();

  const std::string& room() const { return room_; }
  std::uint64_t id() const { return id_; }  ///< 0: has not joined

 private:
  struct Waiting {
    Message message;
    bool reliable;
  };

  void read();
  /// False to disconnect.
  bool hear(std::span<const std::uint8_t> bytes);
  void write();
  void end(boost::beast::websocket::close_code code);

  MemberHost& host_;
  std::string room_;
  MemberLimits limits_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::asio::steady_timer patience_;
  Request request_;
  boost::beast::flat_buffer incoming_{kMaxWireBytes};
  page_server::Allowance messages_;
  page_server::Allowance bytes_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  Message writing_;
  std::uint64_t id_ = 0;
  bool open_ = false;
  bool closed_ = false;
};

}  // namespace tandem::room
