// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "work_precision/options.h"

#include <cmath>

#include "arguments/arguments.h"

namespace tandem::bench {

RunOptions parse_arguments(std::span<const std::string_view> words) {
  RunOptions options;
  const auto count = [](auto& into) {
    return [&into](demos::Argument& in) {
      into = in.number(1, 1'000'000'000, "a whole number, 1 or more");
    };
  };
  const auto flag = [](bool& into) { return [&into](demos::Argument&) { into = true; }; };
  const auto text = [](std::string& into) {
    return [&into](demos::Argument& in) { into = in.text(); };
  };
  demos::read_arguments(
      words, {{"--json", flag(options.json)},
              {"--stages", flag(options.stages)},
              {"--per-frame", flag(options.per_frame)},
              {"--sleeping", flag(options.settings.sleeping)},
              {"--scene", text(options.scene)},
              {"--reference", text(options.reference)},
              {"--substeps", count(options.settings.substeps)},
              {"--iterations", count(options.settings.iterations)},
              {"--velocity-iterations", count(options.settings.velocity_iterations)},
              {"--threads", count(options.settings.threads)},
              {"--size", count(options.size)},
              {"--frames", count(options.frames)},
              {"--seconds", [&options](demos::Argument& in) {
                 options.frames = static_cast<int>(
                     std::lround(60.0 * in.number(0.0, 1e6, "a number from 0 to 1e6 s")));
               }}});
  if (options.scene.empty()) throw demos::UsageError("--scene must be given");
  return options;
}

}  // namespace tandem::bench
