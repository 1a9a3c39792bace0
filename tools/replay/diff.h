// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "replay/reader.h"
#include "replay/replayer.h"
#include "scenes/scenario.h"

namespace tandem::demos {

/// The first thing in which two traces of one peer differ, of those things that are in both;
/// nothing where one goes on where the other ends, or both are the same. Nothing is run again: so
/// traces of two programs or machines can be compared.
/// @throws TraceError
std::optional<Departure> first_difference(TraceReader& a, TraceReader& b);

/// How far the copies of a body are apart at one step of the first peer.
struct Apart {
  std::uint64_t step = 0;
  consensus::SessionTime time = 0;  ///< ns, the step's end
  std::size_t body = 0;
  double distance = 0.0;  ///< m
};

/// Two peers of one session, run again side by side.
struct TwoViews {
  std::uint64_t compared = 0;   ///< steps of the first at times that the second has too
  std::optional<Apart> beyond;  ///< the first that are further apart than the tolerance
  std::optional<Apart> furthest;
  std::optional<Departure> a, b;  ///< where a replay was not as its trace
};

/// Positions of all bodies after each step of `a`, against those of `b` at the same session time,
/// on the line between its steps. @param tolerance  m
/// @throws as Replayer
TwoViews compare_views(const Scenario& scenario, std::span<const std::byte> a,
                       std::span<const std::byte> b, double tolerance);

}  // namespace tandem::demos
