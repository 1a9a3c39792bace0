// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/scenario_list.h"

#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/pile.h"
#include "scenes/room.h"
#include "scenes/tennis.h"

namespace tandem::demos {

std::unique_ptr<Scenario> make_scenario(const std::string& name, const std::string& variant) {
  if (name == "piano") {
    PianoOptions options;
    if (!PianoOptions::parse(variant, options)) return nullptr;
    return std::make_unique<PianoScenario>(options);
  }
  if (!variant.empty()) return nullptr;
  if (name == "cliff") return std::make_unique<CliffScenario>();
  if (name == "cubes") return std::make_unique<CubesScenario>();
  if (name == "pile") return std::make_unique<PileScenario>();
  if (name == "room") return std::make_unique<RoomScenario>();
  if (name == "tennis") return std::make_unique<TennisScenario>();
  return nullptr;
}

}  // namespace tandem::demos
