// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/consensus/virtual_network.h"

namespace tandem::demos {

/// ms: how long each packet of a link in virtual time is under way, without waiting for anybody's
/// step; to 0.1 ms. What is lost is left out.
/// @param rate     packets each second, > 0     @param seconds  how long they are sent
/// @throws std::invalid_argument where the options are not valid
std::vector<double> link_latencies(const consensus::LinkOptions& link, double rate, double seconds,
                                   std::uint64_t seed);

}  // namespace tandem::demos
