// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/udp.h"

#include "session_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

net::Clock clock_of(tandem_clock_source clock) {
  switch (clock) {
    case TANDEM_CLOCK_SESSION:
      return net::Clock::Session;
    case TANDEM_CLOCK_SYSTEM:
      return net::Clock::System;
    case TANDEM_CLOCK_NONE:
      return net::Clock::None;
  }
  refuse_unlisted("clock", clock, "tandem_clock_source");
}

net::UdpOptions udp_options(const tandem_udp_def& def) {
  const Wire wire = wire_of(def.connect, def.credentials);
  net::UdpOptions options;
  options.self = def.self;
  options.scene_hash = def.scene_hash;
  options.listen_port = port_of("listen_port", def.listen_port);
  if (def.listen_address != nullptr) options.listen_address = def.listen_address;
  options.connect = wire.connect;
  options.session_key = wire.session_key.value_or(net::Key{});
  options.identity = wire.identity;
  options.trusted = wire.trusted;
  options.organiser = wire.organiser;
  options.certificate = wire.certificate;
  options.kbit_per_s = def.kbit_per_s;
  options.clock = clock_of(def.clock);
  options.relay = def.relay != 0;
  return options;
}

}  // namespace

tandem_session* tandem_session_create_udp(tandem_world* world, const tandem_udp_def* udp,
                                          const tandem_session_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const net::UdpOptions options = udp_options(required(udp, "udp"));
    auto made = opened(required(world, "world"), options, options_of(required(def, "def")));
    made->port = port_reader<net::UdpTransport>(*made->session);
    return made.release();
  });
}
