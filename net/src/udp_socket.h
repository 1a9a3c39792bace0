// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <asio/steady_timer.hpp>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "bound_socket.h"
#include "datagram_batch.h"
#include "flood_gauge.h"
#include "tandem/net/udp.h"
#include "timer_resolution.h"
#include "udp_node.h"

namespace tandem::net {

/// Socket, clock and thread of a UdpNode. All else is in the node.
class UdpSocket {
 public:
  /// Throws std::system_error if it cannot bind.
  UdpSocket(const UdpOptions& options, const UdpNodeOptions& node);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  const UdpOptions& options() const { return options_; }
  std::uint16_t local_port() const { return socket_.port(); }
  /// Dial over this path from now on.
  void connect(std::shared_ptr<DatagramPath> path);
  void disconnect(const DatagramPath& path);
  std::vector<UdpLookup> lookups();

  /// Calls `use(node, now)` under the lock; then the network thread continues.
  template <class Use>
  auto with(bool wakes, Use&& use) {
    const std::scoped_lock lock(mutex_);
    if (wakes) wake();
    const std::int64_t time = now();
    follow_system_clock(time);
    return use(node_, time);
  }

 private:
  using Endpoint = BoundSocket::Endpoint;

  struct Lookup {
    UdpLookup status;  // written by the network thread alone, under the lock
    asio::steady_timer again;
  };

  static std::int64_t now();
  UdpNodeOptions started(UdpNodeOptions node) const;
  void follow_system_clock(std::int64_t time);
  void run();
  void look_up(Lookup& lookup);
  void dial(Lookup& lookup, std::span<const Endpoint> found);
  void look_up_again(Lookup& lookup, const std::string& reason);
  void wake();  // call under the lock
  void receive();
  void on_readable();
  void step();
  void send(std::span<const std::byte> datagram, const Address& to);

  const UdpOptions options_;
  std::mutex mutex_;  // for node and lookups, held for memory and arithmetic only
  [[maybe_unused]] TimerResolution timer_resolution_;
  asio::io_context context_{1};
  BoundSocket socket_;
  UdpNode node_;
  asio::steady_timer timer_{context_};
  asio::ip::udp::resolver resolver_{context_};
  std::vector<std::shared_ptr<DatagramPath>> paths_;  // by number; null: disconnected
  std::atomic<std::size_t> path_waiting_ = 0;         // datagrams for the network thread
  std::vector<Lookup> lookups_;                       // one for each entry of options_.connect
  bool wake_posted_ = false;
  bool waiting_ = false;                  // for the socket
  std::int64_t flush_until_ = INT64_MAX;  // set during shutdown
  bool left_ = false;
  DatagramBatch batch_;
  FloodGauge flood_;
  std::thread thread_;
};

}  // namespace tandem::net
