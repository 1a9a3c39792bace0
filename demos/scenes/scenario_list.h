// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "scenes/scenario.h"

namespace tandem::demos {

/// One of the demos' scenarios by its name. @param variant  "" = its default
/// @return null where there is none of that name, or no such variant of it
std::unique_ptr<Scenario> make_scenario(const std::string& name, const std::string& variant = "");
/// Their names, for people.
inline constexpr std::string_view kScenarioNames = "cliff, cubes, piano, pile, room, tennis";

}  // namespace tandem::demos
