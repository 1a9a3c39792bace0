// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "peer_table.h"
#include "tandem/net/tcp.h"
#include "tcp_dialler.h"
#include "tcp_handshake.h"
#include "tcp_link.h"
#include "tcp_listener.h"
#include "tcp_report.h"
#include "tcp_security.h"
#include "wire.h"

namespace tandem::net {

/// The network thread: its links, the meaning of peers' frames, and one periodic sweep for
/// timeouts. All state but the table and the report belongs to that thread.
class TcpMesh final : private TcpLinkOwner {
 public:
  /// `security` may be null: frames in the clear. Throws std::system_error if it cannot listen.
  TcpMesh(const TcpOptions& options, PeerTable& table, TcpReport& report,
          std::unique_ptr<TcpSecurity> security);
  ~TcpMesh();

  std::uint16_t local_port() const { return listener_.port(); }

  // From the application's thread; they only post.
  void wake(PeerId peer);
  void cut(std::uint64_t link, const std::string& reason);
  void change_group(std::vector<std::byte> signed_change);
  std::uint64_t group() const { return group_; }

 private:
  using Clock = std::chrono::steady_clock;

  // tcp_mesh.cpp: life, links, time
  void run();
  void on_accepted(const std::shared_ptr<TcpLink>& link);
  void make_room();
  void arm_sweep();
  void sweep();
  void begin_shutdown();
  void release();
  std::shared_ptr<TcpLink> new_link();
  /// For a dial.
  std::shared_ptr<TcpLink> open(std::uint64_t dial);
  /// The present links, for loops that may close some.
  std::vector<std::shared_ptr<TcpLink>> snapshot() const;
  TcpLink* find_link(std::uint64_t serial);

  // tcp_protocol.cpp: frames
  void on_frame(TcpLink& link, const FrameBuffer::Frame& frame) override;
  void on_malformed(TcpLink& link, const std::string& reason) override;
  void on_forged(TcpLink& link, const std::string& reason) override;
  bool may_read(TcpLink& link) override;
  void on_writable(TcpLink& link, std::vector<std::byte>& out) override;
  void on_closed(TcpLink& link, const std::string& reason) override;
  void on_attached(TcpLink& link, const PeerTable::AttachResult& result);
  void introduce(TcpLink& newcomer);
  Credentials::Changed take_group_change(std::span<const std::byte> change);
  void send_group_change(TcpLink& link);
  void expel();
  void on_peer_frame(TcpLink& link, const FrameBuffer::Frame& frame);
  void on_payload(TcpLink& link, consensus::Delivery delivery, std::uint64_t sequence,
                  std::span<const std::byte> bytes);

  const TcpOptions options_;
  PeerTable& table_;
  TcpReport& report_;
  const std::unique_ptr<TcpSecurity> security_;
  asio::io_context context_{1};
  asio::steady_timer sweep_timer_{context_};
  std::map<std::uint64_t, std::shared_ptr<TcpLink>> links_;  // by serial: oldest first
  std::uint64_t next_serial_ = 1;
  TcpListener listener_;
  TcpDialler dialler_;
  TcpHandshake handshake_;
  SteadyTime last_sweep_;
  SteadyTime next_expel_{};
  std::atomic<std::uint64_t> group_{0};
  std::optional<SteadyTime> shutdown_deadline_;
  std::thread thread_;
};

}  // namespace tandem::net
