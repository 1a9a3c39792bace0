// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "demos/engine/engine.h"

namespace tandem::bench {

struct RunOptions {
  std::string scene;
  int size = 0;  ///< of a scene of joints; 0: its own
  Settings settings;
  int frames = 0;         ///< 0 = the scene's length
  std::string reference;  ///< path of the chain's reference
  bool json = false;
  bool stages = false;
  bool per_frame = false;
};

/// @throws demos::UsageError
RunOptions parse_arguments(std::span<const std::string_view> words);

}  // namespace tandem::bench
