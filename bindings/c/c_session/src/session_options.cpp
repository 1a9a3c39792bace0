// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <optional>
#include <sstream>
#include <string>

#include "session_impl.h"
#include "sharing.h"
#include "tandem/net/udp.h"
#include "tandem/pbd/validate.h"

using namespace tandem;
using namespace tandem::c;

namespace {

std::optional<net::Key> key_or_none(const tandem_key* key) {
  return key != nullptr ? std::optional(key_of(*key)) : std::nullopt;
}

SpawnOptions spawning_of(const tandem_session_def& def) {
  SpawnOptions options;
  void* const user = def.user;
  if (def.make != nullptr) {
    options.make = [make = def.make, user](std::string_view what) {
      tandem_body body = TANDEM_NO_BODY;
      const std::string text(what);
      if (make(user, text.c_str(), text.size(), &body) == 0) {
        pbd::detail::refuse("what", "something that make knows");
      }
      return from_c(body);
    };
  }
  if (def.remove != nullptr) {
    options.remove = [remove = def.remove, user](pbd::BodyId body) { remove(user, to_c(body)); };
  }
  options.max_bodies = def.max_spawned;
  options.max_of_one = def.max_spawned_of_one;
  return options;
}

}  // namespace

Wire tandem::c::wire_of(const char* connect, const tandem_credentials& credentials) {
  Wire wire{.connect = {},
            .session_key = key_or_none(credentials.session_key),
            .identity = key_or_none(credentials.identity),
            .trusted = {},
            .organiser = key_or_none(credentials.organiser),
            .certificate = {}};
  std::istringstream addresses(connect != nullptr ? connect : "");
  for (std::string address; addresses >> address;) {
    wire.connect.push_back(net::parse_host_port(address));
  }
  for (std::size_t i = 0; i < credentials.trusted_count; ++i) {
    const tandem_trusted& peer = (&required(credentials.trusted, "trusted"))[i];
    wire.trusted.push_back({.peer = peer.peer, .public_key = key_of(peer.public_key)});
  }
  if (credentials.certificate_size > 0) {
    const auto& first =
        required(static_cast<const std::byte*>(credentials.certificate), "certificate");
    wire.certificate.assign(&first, &first + credentials.certificate_size);
  }
  return wire;
}

std::uint16_t tandem::c::port_of(const char* field, std::int32_t port) {
  if (port < 0 || port > UINT16_MAX) {
    pbd::detail::refuse(field, "from 0 to 65535", std::to_string(port));
  }
  return static_cast<std::uint16_t>(port);
}

SessionOptions tandem::c::options_of(const tandem_session_def& def) {
  pbd::detail::require_in(0.1, 1e4, "tandem_session_def", "rate", def.rate, "steps a second");
  SessionOptions options;
  options.pace = net::PhysicsClockOptions::at_rate(def.rate);
  options.peer = from_c(def.peer);
  options.spawning = spawning_of(def);
  if (def.clock != nullptr) {
    options.clock = [clock = def.clock, user = def.user] { return clock(user); };
  }
  return options;
}

void tandem_session_def_init(tandem_session_def* def) {
  if (def == nullptr) return;
  const SpawnOptions spawning;
  *def = {.rate = 60.0,
          .peer = to_c(consensus::PeerOptions()),
          .make = nullptr,
          .remove = nullptr,
          .max_spawned = static_cast<uint32_t>(spawning.max_bodies),
          .max_spawned_of_one = static_cast<uint32_t>(spawning.max_of_one),
          .clock = nullptr,
          .user = nullptr};
}

void tandem_tcp_def_init(tandem_tcp_def* def) {
  if (def == nullptr) return;
  *def = {};
  def->listen_port = -1;
}

void tandem_udp_def_init(tandem_udp_def* def) {
  if (def == nullptr) return;
  *def = {};
  const net::UdpOptions defaults;
  def->clock = TANDEM_CLOCK_SESSION;
  def->kbit_per_s = defaults.kbit_per_s;
  def->relay = defaults.relay ? 1 : 0;
}
