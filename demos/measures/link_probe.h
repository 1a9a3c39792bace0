// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/consensus/virtual_network.h"

namespace tandem::demos {

/// Transit time of each packet of a link in virtual time, ms, to 0.1 ms, without lost packets and
/// the wait for a step.
/// @param rate     packets per second, > 0     @param seconds  of sending
/// @throws std::invalid_argument if the options are not valid
std::vector<double> link_latencies(const consensus::LinkOptions& link, double rate, double seconds,
                                   std::uint64_t seed);

}  // namespace tandem::demos
