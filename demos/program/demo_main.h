// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "scenes/scenario.h"
#include "session/options.h"

namespace tandem::demos {

/// Makes the scenario in one of its variants; "" is the default one.
/// @throws UsageError if there is no such variant
using ScenarioFactory = std::function<std::unique_ptr<Scenario>(const std::string& variant)>;

/// The main() of a demo. Returns the exit code: 0; 1 for a fault of the run or the system; 2 for an
/// invalid command line.
int demo_main(int argc, char** argv, const ScenarioFactory& factory);

/// The main() of a demo without variants.
template <class Kind>
int demo_main(int argc, char** argv) {
  return demo_main(argc, argv, [](const std::string& variant) -> std::unique_ptr<Scenario> {
    if (!variant.empty()) throw UsageError("this scenario has no --variant");
    return std::make_unique<Kind>();
  });
}

}  // namespace tandem::demos
