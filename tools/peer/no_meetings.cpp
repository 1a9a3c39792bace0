// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "peer/meetings.h"

namespace tandem::demos {

class Meetings::Impl {};

Meetings::Meetings(const PeerConfig& config, Network& /*network*/, Log& /*log*/) {
  if (config.meetings.empty()) return;
  throw std::runtime_error("network.ice needs a build with TANDEM_WITH_ICE (Debian: libnice-dev)");
}
Meetings::~Meetings() = default;
void Meetings::look() {}

}  // namespace tandem::demos
