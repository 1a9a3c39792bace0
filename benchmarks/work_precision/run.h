// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "demos/engine/engine.h"

namespace tandem::bench {

/// One scene, one engine, one setting: how long a frame takes and how far the result is off.
///   work_precision_tandem --scene stacks [--substeps N] [--iterations N] [--velocity-iterations N]
///                         [--threads N] [--frames N | --seconds S] [--json] [--stages]
///                         [--per-frame] [--sleeping] [--reference FILE]
/// What is not given is the engine's default. work_precision.py runs them all.
/// @return  the exit code: 0, or 2 for arguments that it does not understand
int work_precision_main(int argc, const char* const* argv, const MakeEngine& make);

}  // namespace tandem::bench
