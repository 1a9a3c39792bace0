// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/tcp.h"

#include "session_impl.h"
#include "tandem/pbd/validate.h"

using namespace tandem;
using namespace tandem::c;

namespace {

net::TcpOptions tcp_options(const tandem_tcp_def& def) {
  const Wire wire = wire_of(def.connect, def.credentials);
  net::TcpOptions options;
  options.self = def.self;
  options.scene_hash = def.scene_hash;
  if (def.listen_port < -1 || def.listen_port > 65535) {
    pbd::detail::refuse("listen_port", "from -1 to 65535", std::to_string(def.listen_port));
  }
  if (def.listen_port >= 0) options.listen_port = port_of("listen_port", def.listen_port);
  if (def.listen_address != nullptr) options.listen_address = def.listen_address;
  options.connect = wire.connect;
  options.session_key = wire.session_key;
  options.identity = wire.identity;
  options.trusted = wire.trusted;
  options.organiser = wire.organiser;
  options.certificate = wire.certificate;
  options.insecure = def.insecure != 0;
  return options;
}

}  // namespace

tandem_session* tandem_session_create_tcp(tandem_world* world, const tandem_tcp_def* tcp,
                                          const tandem_session_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const net::TcpOptions options = tcp_options(required(tcp, "tcp"));
    auto made = opened(required(world, "world"), options, options_of(required(def, "def")));
    made->port = port_reader<net::TcpTransport>(*made->session);
    return made.release();
  });
}
