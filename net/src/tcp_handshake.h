// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "peer_table.h"
#include "tcp_dialler.h"
#include "tcp_link.h"
#include "tcp_report.h"
#include "tcp_security.h"
#include "wire.h"

namespace tandem::net {

/// Time that a link waits for the other end to close after a Goodbye.
constexpr std::chrono::milliseconds kLinger{500};

/// Turns a connection into a peer's link: keys, identity of the other end, admission. Network
/// thread only.
class TcpHandshake {
 public:
  /// @param security  may be null: frames in the clear     @param port  on which this process
  /// listens
  TcpHandshake(const TcpOptions& options, PeerTable& table, TcpReport& report, TcpDialler& dialler,
               TcpSecurity* security, std::uint16_t port)
      : options_(options),
        table_(table),
        report_(report),
        dialler_(dialler),
        security_(security),
        port_(port) {}

  /// The link is connected. Its options_.handshake_timeout begins.
  void start(TcpLink& link);
  /// Any frame but a Goodbye before the link is attached. Returns a result once it is attached.
  std::optional<PeerTable::AttachResult> on_frame(TcpLink& link, const FrameBuffer::Frame& frame);
  /// Bytes that are not a frame, before the link is attached.
  void on_malformed(TcpLink& link, const std::string& reason);

 private:
  void on_key_frame(TcpLink& link, const FrameBuffer::Frame& frame);
  void on_hello(TcpLink& link, const Hello& hello);
  std::optional<PeerTable::AttachResult> on_welcome(TcpLink& link, const Welcome& welcome);
  void greet(TcpLink& link);
  void send_welcome(TcpLink& link);
  void refuse(TcpLink& link, const std::string& reason, bool rejected);
  std::optional<std::string> mismatch(const Hello& hello) const;

  const TcpOptions& options_;
  PeerTable& table_;
  TcpReport& report_;
  TcpDialler& dialler_;
  TcpSecurity* security_;
  std::uint16_t port_;
  std::uint64_t next_ticket_ = 1;
};

}  // namespace tandem::net
