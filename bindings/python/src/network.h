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

/// Network of a session.
class Network {
 public:
  virtual ~Network() = default;
  /// Keeps only references to its arguments; must outlive the session.
  virtual std::unique_ptr<tandem::Session> open(const Simulation& simulation, PeerId self,
                                                const SessionOptions& options) = 0;
  /// Port of a session that it opened; 0 if there is none.
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
