// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world.h"

namespace tandem::stability_bench {

/// What peers disagree about.
enum class Kind : std::uint8_t { Free, Spring, Stack, Row, Chain };
inline constexpr std::array kKinds = {Kind::Free, Kind::Spring, Kind::Stack, Kind::Row,
                                      Kind::Chain};
inline constexpr std::array<std::string_view, 5> kKindNames = {"free", "spring", "stack", "row",
                                                               "chain"};

/// One peer's copy. All bodies are shared.
struct Copy {
  std::unique_ptr<pbd::World> world;
  std::unique_ptr<collision::CollisionScene> contacts;  ///< null where nothing touches
  std::vector<pbd::BodyId> bodies;
};

/// @param apart  m, how far this copy's bodies begin from where the other's do
Copy build(Kind kind, double apart);

}  // namespace tandem::stability_bench
