// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "work_precision/options.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace tandem::bench {
namespace {

int count(std::string_view name, std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 1) {
    throw std::invalid_argument(std::string(name) + " = " + std::string(text) +
                                " breaks: a whole number, 1 or more");
  }
  return value;
}

}  // namespace

RunOptions parse_arguments(int argc, const char* const* argv) {
  RunOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--json") {
      options.json = true;
      continue;
    }
    if (name == "--stages") {
      options.stages = true;
      continue;
    }
    if (name == "--per-frame") {
      options.per_frame = true;
      continue;
    }
    if (name == "--sleeping") {
      options.settings.sleeping = true;
      continue;
    }
    if (++i == argc) throw std::invalid_argument(name + ": unknown, or its value is missing");
    const std::string value = argv[i];
    if (name == "--scene") {
      options.scene = value;
    } else if (name == "--reference") {
      options.reference = value;
    } else if (name == "--substeps") {
      options.settings.substeps = count(name, value);
    } else if (name == "--iterations" || name == "--position-iterations") {
      options.settings.iterations = count(name, value);
    } else if (name == "--velocity-iterations") {
      options.settings.velocity_iterations = count(name, value);
    } else if (name == "--threads") {
      options.settings.threads = count(name, value);
    } else if (name == "--frames") {
      options.frames = count(name, value);
    } else if (name == "--seconds") {
      options.frames = static_cast<int>(std::lround(60.0 * std::strtod(value.c_str(), nullptr)));
    } else {
      throw std::invalid_argument(name + ": unknown");
    }
  }
  if (options.scene.empty()) throw std::invalid_argument("--scene is missing");
  return options;
}

}  // namespace tandem::bench
