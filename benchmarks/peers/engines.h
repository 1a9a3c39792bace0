// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "demos/engine/engine.h"

namespace tandem::bench {

/// The engines of this build, Tandem first.
std::vector<std::pair<std::string, MakeEngine>> built_engines();

}  // namespace tandem::bench
