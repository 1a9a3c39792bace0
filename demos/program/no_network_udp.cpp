// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "program/network.h"

namespace tandem::demos {

std::unique_ptr<Network> make_udp_network(const DemoOptions& /*options*/,
                                          std::uint64_t /*scene_hash*/) {
  throw std::runtime_error("UDP needs a build with libsodium (Debian: libsodium-dev, pkgconf)");
}

}  // namespace tandem::demos
