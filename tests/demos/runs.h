// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

#include "session/options.h"
#include "session/track.h"
#include "support/catch.h"

namespace tandem::demos {

/// A run that tells nothing.
inline DemoOptions quiet(int profile, double seconds) {
  DemoOptions options;
  options.print = Print::Nothing;
  options.seconds = seconds;
  options.profile = profile;
  return options;
}

/// Value of `name` by a peer's referee or users.
inline double number(const PeerRecord& peer, const std::string& name) {
  for (const auto& [key, value] : peer.outcome) {
    if (key == name) return value;
  }
  FAIL("no outcome " << name);
  return 0.0;
}

}  // namespace tandem::demos
