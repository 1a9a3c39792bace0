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

/// The first difference between two traces of one peer, over their common length; nothing if there
/// is none. Nothing is replayed, so the programs or machines may differ.
/// @throws TraceError
std::optional<Departure> first_difference(TraceReader& a, TraceReader& b);

/// Distance between a body's copies at one step of the first peer.
struct Apart {
  std::uint64_t step = 0;
  consensus::SessionTime time = 0;  ///< ns, the step's end
  std::size_t body = 0;
  double distance = 0.0;  ///< m
};

/// Two peers of one session, replayed side by side.
struct TwoViews {
  std::uint64_t compared = 0;   ///< steps of the first at times that the second has too
  std::optional<Apart> beyond;  ///< the first distance above the tolerance
  std::optional<Apart> furthest;
  std::optional<Departure> a, b;  ///< departures of the replays from their traces
};

/// Compares all bodies after each step of `a` with those of `b` at the same session time,
/// interpolated between its steps. @param tolerance  m
/// @throws as Replayer
TwoViews compare_views(const Scenario& scenario, std::span<const std::byte> a,
                       std::span<const std::byte> b, double tolerance);

}  // namespace tandem::demos
