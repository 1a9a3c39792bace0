// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <stdexcept>

#include "peers/engines.h"
#include "support/catch.h"

namespace tandem::bench {

/// Runs `check(engine)` for each engine whose adapter takes the scene, under its name. Tandem's
/// takes all.
template <class F>
void for_each_engine(const Scene& scene, const F& check) {
  for (const auto& [name, make] : built_engines()) {
    INFO(name);
    std::unique_ptr<Engine> engine;
    try {
      engine = make(scene, {});
    } catch (const std::invalid_argument&) {
      CHECK(name != "tandem");
      continue;
    }
    check(*engine);
  }
}

}  // namespace tandem::bench
