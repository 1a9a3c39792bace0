// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Replaces the view in builds without it.
#include <stdexcept>

#include "view/live_runner.h"
#include "view/world_view.h"

namespace tandem::demos::view {

bool has_view() { return false; }

std::string missing() { return TANDEM_VIEW_MISSING " (docs/view.md)"; }

RunResult run_live(const Scenario& /*scenario*/, const DemoOptions& /*options*/) {
  throw std::logic_error("this build has no view");
}

std::unique_ptr<WorldView> make_world_view(WorldViewContext /*context*/, const Scene& /*scene*/,
                                           const consensus::Peer& /*peer*/) {
  throw std::logic_error("this build has no view");
}

}  // namespace tandem::demos::view
