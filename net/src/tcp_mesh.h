// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
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
#include "tandem/pbd/random.h"
#include "tcp_link.h"
#include "tcp_security.h"
#include "wire.h"

namespace tandem::net {

/// How long a link waits for the other end to close after a Goodbye.
constexpr std::chrono::milliseconds kLinger{500};

/// The network thread: listens, dials, shakes hands, spreads addresses, and watches the time by one
/// periodic sweep. All state but the table belongs to that thread.
class TcpMesh final : private TcpLinkOwner {
 public:
  /// `security` may be null: frames in the clear. Throws std::system_error where it cannot listen.
  TcpMesh(const TcpOptions& options, PeerTable& table, std::unique_ptr<TcpSecurity> security);
  ~TcpMesh();

  std::uint16_t local_port() const { return local_port_; }

  // From the application's thread; they only post.
  void wake(PeerId peer);
  void cut(std::uint64_t link, const std::string& reason);
  void change_group(std::vector<std::byte> signed_change);
  std::uint64_t group() const { return group_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Endpoint = asio::ip::tcp::endpoint;

  /// An address to dial: given by the application, told by the peer itself, or by another one.
  struct Dial {
    std::uint64_t serial = 0;
    HostPort address;
    bool lasting = false;  // not hearsay only, which is forgotten after some failures
    PeerId peer = 0;
    bool is_self = false;
    bool busy = false;  // looking up, connecting or shaking hands
    std::uint64_t attempts = 0;
    SteadyTime due{};
    std::string reason;
  };

  // tcp_mesh.cpp: life, listening, time
  void listen();
  void run();
  void accept();
  void on_accept(const std::shared_ptr<TcpLink>& link, const std::error_code& error);
  bool over_rate(TcpLink& link) const;
  void make_room();
  void arm_sweep();
  void sweep();
  void begin_shutdown();
  void release();
  std::shared_ptr<TcpLink> new_link();
  /// The links as they are now, for loops that may close some.
  std::vector<std::shared_ptr<TcpLink>> snapshot() const;
  TcpLink* find_link(std::uint64_t serial);

  // tcp_dial.cpp: dialling and addresses
  void add_dial(const HostPort& address, PeerId peer, bool lasting, SteadyTime due);
  void sweep_dials(SteadyTime now);
  bool may_dial(const Dial& dial) const;
  /// Without keys only this machine, unless the application has said otherwise.
  bool may_reach(const asio::ip::address& address) const;
  void start_dial(Dial& dial);
  void look_up(std::uint64_t serial);
  void connect(Dial& dial, const std::vector<Endpoint>& endpoints);
  void dial_failed(std::uint64_t serial, const std::string& reason);
  void redial_peer(PeerId peer, bool lasted);
  void learn_address(const TcpLink& link);
  void on_addresses(const TcpLink& link, const std::vector<PeerAddress>& addresses);
  void introduce(TcpLink& newcomer);
  SteadyTime::duration backoff(std::uint64_t attempts);
  Dial* find_dial(std::uint64_t serial);
  void publish_dials();

  // tcp_protocol.cpp: frames
  void on_frame(TcpLink& link, const FrameBuffer::Frame& frame) override;
  void on_malformed(TcpLink& link, const std::string& reason) override;
  void on_forged(TcpLink& link, const std::string& reason) override;
  bool may_read(TcpLink& link) override;
  void on_writable(TcpLink& link, std::vector<std::byte>& out) override;
  void on_closed(TcpLink& link, const std::string& reason) override;
  void on_key_frame(TcpLink& link, const FrameBuffer::Frame& frame);
  void on_hello(TcpLink& link, const Hello& hello);
  void on_welcome(TcpLink& link, const Welcome& welcome);
  void on_goodbye(TcpLink& link, const std::string& text);
  void on_group_change(TcpLink& link, std::span<const std::byte> change);
  TcpSecurity::Changed take_group_change(std::span<const std::byte> change);
  void send_group_change(TcpLink& link);
  void expel();
  void on_peer_frame(TcpLink& link, const FrameBuffer::Frame& frame);
  void on_payload(TcpLink& link, Delivery delivery, std::uint64_t sequence,
                  std::span<const std::byte> bytes);
  void ask_for_keys(TcpLink& link);
  void greet(TcpLink& link);
  void send_welcome(TcpLink& link);
  void refuse(TcpLink& link, const std::string& reason, bool rejected);
  std::optional<std::string> mismatch(const Hello& hello) const;

  const TcpOptions options_;
  PeerTable& table_;
  const std::unique_ptr<TcpSecurity> security_;
  asio::io_context context_{1};
  asio::ip::tcp::acceptor acceptor_{context_};
  asio::ip::tcp::resolver resolver_{context_};
  asio::steady_timer sweep_timer_{context_};
  std::map<std::uint64_t, std::shared_ptr<TcpLink>> links_;  // by serial: oldest first
  std::vector<Dial> dials_;
  std::uint16_t local_port_ = 0;
  std::uint64_t next_serial_ = 1;
  std::uint64_t next_ticket_ = 1;
  pbd::SplitMix64 jitter_;
  SteadyTime last_sweep_{};
  SteadyTime next_expel_{};
  std::atomic<std::uint64_t> group_{0};
  SteadyTime accept_again_{};  // after an error; zero: accepting
  std::optional<SteadyTime> shutdown_deadline_;
  std::thread thread_;
};

}  // namespace tandem::net
