// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "copies/copy.h"

namespace tandem::stability_bench {

/// What peers disagree about.
enum class Kind : std::uint8_t { Free, Spring, Stack, Row, Chain };
inline constexpr std::array kKinds = {Kind::Free, Kind::Spring, Kind::Stack, Kind::Row,
                                      Kind::Chain};
inline constexpr std::array<std::string_view, 5> kKindNames = {"free", "spring", "stack", "row",
                                                               "chain"};

/// @param apart  m, how far this copy's bodies begin from where the other's do
peers_bench::Copy build(Kind kind, double apart);

}  // namespace tandem::stability_bench
