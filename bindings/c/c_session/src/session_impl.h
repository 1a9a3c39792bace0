// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "guard.h"
#include "tandem/c/tandem.h"
#include "tandem/net/keys.h"
#include "tandem/net/session.h"
#include "tandem/session.h"
#include "world_impl.h"

namespace tandem::c {

/// Adapts a world to Simulation.
class Stepped {
 public:
  explicit Stepped(tandem_world& world) : world_(world) {}
  pbd::World& world() { return world_.world; }
  const pbd::StepReport& step(double dt) { return world_.step(dt); }

 private:
  tandem_world& world_;
};

inline net::Key key_of(const tandem_key& key) {
  net::Key result{};
  std::ranges::copy(key.bytes, result.begin());
  return result;
}

/// Options common to TCP and UDP.
struct Wire {
  std::vector<net::HostPort> connect;
  std::optional<net::Key> session_key;
  std::optional<net::Key> identity;
  std::vector<net::TrustedPeer> trusted;
  std::optional<net::Key> organiser;
  std::vector<std::byte> certificate;
};

/// @param connect  null, or "HOST:PORT" separated by spaces
/// @throws std::invalid_argument naming field, value and rule
Wire wire_of(const char* connect, const tandem_credentials& credentials);
/// @throws as above
std::uint16_t port_of(const char* field, std::int32_t port);
/// The session keeps `def`'s functions. @throws as above
SessionOptions options_of(const tandem_session_def& def);

}  // namespace tandem::c

struct tandem_session {
  explicit tandem_session(tandem_world& world) : stepped(world) {}

  /// Collect peers that join or leave.
  void listen();
  /// Collect events received before the step that begins at `now`.
  void hear();

  tandem::c::Stepped stepped;
  // Results of the last advance:
  std::vector<tandem::PeerId> joined;
  std::vector<tandem::PeerId> left;
  std::deque<tandem::consensus::Event> events;  ///< a deque: addresses stay valid
  bool advancing = false;
  std::function<std::uint16_t()> port;       ///< empty without a socket of its own
  std::unique_ptr<tandem::Session> session;  ///< destroyed first
};

namespace tandem::c {

/// With `transport`: options of one, or one itself.
template <class Transport>
std::unique_ptr<tandem_session> opened(tandem_world& world, Transport& transport,
                                       const SessionOptions& options) {
  auto made = std::make_unique<tandem_session>(world);
  made->session = std::make_unique<Session>(Simulation(made->stepped), transport, options);
  made->listen();
  return made;
}

/// For a session whose transport is a `Socket`.
template <class Socket>
std::function<std::uint16_t()> port_reader(Session& session) {
  return [&session] { return dynamic_cast<Socket&>(session.transport()).local_port(); };
}

}  // namespace tandem::c
