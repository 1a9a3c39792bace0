// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "copies/copy.h"

namespace tandem::stability_bench {

/// The scenes of the disagreement.
enum class Kind : std::uint8_t { Free, Spring, Stack, Row, Chain };
inline constexpr std::array kKinds = {Kind::Free, Kind::Spring, Kind::Stack, Kind::Row,
                                      Kind::Chain};
inline constexpr std::array<std::string_view, 5> kKindNames = {"free", "spring", "stack", "row",
                                                               "chain"};

/// @param apart  m, initial offset of this copy's bodies from the other's
peers_bench::Copy build(Kind kind, double apart);

}  // namespace tandem::stability_bench
