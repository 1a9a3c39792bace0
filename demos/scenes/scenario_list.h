// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "scenes/scenario.h"

namespace tandem::demos {

/// A demo's scenario by its name. @param variant  "" = its default
/// @return null if there is no such name or variant
std::unique_ptr<Scenario> make_scenario(const std::string& name, const std::string& variant = "");
inline constexpr std::string_view kScenarioNames = "cliff, cubes, piano, pile, room, tennis";

}  // namespace tandem::demos
