// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "node_options.h"

#include <chrono>

namespace tandem::net {

namespace {

std::int64_t nanoseconds(std::chrono::milliseconds value) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(value).count();
}

}  // namespace

UdpNodeOptions node_options(const UdpOptions& options) {
  options.validate();
  UdpNodeOptions out;
  HandshakeConfig& own = out.handshake;
  own.self = options.self;
  own.incarnation = options.incarnation;
  if (own.incarnation == 0) {
    own.incarnation =
        static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                       std::chrono::system_clock::now().time_since_epoch())
                                       .count());
  }
  own.scene_hash = options.scene_hash;
  own.idle_timeout_ms = static_cast<std::uint32_t>(options.idle_timeout.count());
  static_cast<Credentials&>(own) = credentials_of(options, options.session_key);

  UdpConnectionOptions& link = out.connection;
  link.channels.state_queue_bytes = options.state_queue_bytes;
  link.channels.reliable_queue_bytes = options.reliable_queue_bytes;
  link.channels.max_message_bytes = options.max_message_bytes;
  link.channels.receive_queue_bytes = options.receive_queue_bytes;
  link.congestion = {.min_kbit = options.min_kbit_per_s, .max_kbit = options.kbit_per_s};
  link.max_datagram = options.max_datagram;
  link.idle_timeout = nanoseconds(options.idle_timeout);
  out.max_peers = options.max_peers;
  out.clock = options.clock;
  out.relay = options.relay;
  out.relay_kbit = options.kbit_per_s;
  out.backoff_min = nanoseconds(options.backoff_min);
  out.backoff_max = nanoseconds(options.backoff_max);
  out.drop_hold = nanoseconds(options.drop_hold);
  return out;
}

}  // namespace tandem::net
