// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "program/network.h"

namespace tandem::demos {

std::unique_ptr<Network> make_nats_network(const DemoOptions& /*options*/,
                                           std::uint64_t /*scene_hash*/) {
  throw std::runtime_error("NATS needs a build with -DTANDEM_WITH_NATS=ON (Debian: libnats-dev)");
}

}  // namespace tandem::demos
