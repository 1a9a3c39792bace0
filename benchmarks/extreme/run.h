// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "measures.h"
#include "scene.h"

namespace tandem::extreme_bench {

struct Scheme {
  std::string_view name;
  consensus::Coupling coupling;
  bool published = false;  ///< the paper's prediction, rules and thresholds
};
inline constexpr Scheme kSchemes[] = {
    {"one-pass", consensus::Coupling::OnePass},
    {"two-step", consensus::Coupling::TwoStep},
    {"two-step-paper", consensus::Coupling::TwoStep, true},
    {"none", consensus::Coupling::None},
};

/// "0", "3", "7": frames of delay; "profile 5": that of the paper.
/// @throws std::invalid_argument for anything else
consensus::LinkOptions link_of(const std::string& name);

Result run(const Scene& scene, const Scheme& scheme, const std::string& link, std::uint64_t seed);

}  // namespace tandem::extreme_bench
