// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

#include "demos/engine/engine.h"

namespace tandem::bench {

struct RunOptions {
  std::string scene;
  Settings settings;
  int frames = 0;         ///< 0 = the scene's length
  std::string reference;  ///< path of the chain's reference
  bool json = false;
  bool stages = false;
  bool per_frame = false;
};

/// @throws std::invalid_argument naming the argument
RunOptions parse_arguments(int argc, const char* const* argv);

}  // namespace tandem::bench
