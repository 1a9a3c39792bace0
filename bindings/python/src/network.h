// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tandem/net/keys.h"
#include "tandem/net/session.h"
#include "tandem/session.h"
#include "values.h"

namespace tandem::python {

/// What sessions go through.
class Network {
 public:
  virtual ~Network() = default;
  /// Keeps nothing but what is handed in; must outlive the session.
  virtual std::unique_ptr<tandem::Session> open(const Simulation& simulation, PeerId self,
                                                const SessionOptions& options) = 0;
  /// Of a session that it opened; 0 where there is none.
  virtual std::uint16_t port(consensus::Transport&) const { return 0; }
  /// Whether its time passes by itself, so that a session can wait for its next step.
  virtual bool runs() const { return true; }
};

using NetworkClass = py::class_<Network, std::shared_ptr<Network>>;

/// 32 bytes or 64 hex digits. @throws std::invalid_argument
net::Key key_of(const py::handle& value);
/// "HOST:PORT" each. @throws std::invalid_argument
std::vector<net::HostPort> addresses(const std::vector<std::string>& texts);

void bind_udp(py::module_& m, NetworkClass& base);

}  // namespace tandem::python
