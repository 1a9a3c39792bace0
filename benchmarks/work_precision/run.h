// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "demos/engine/engine.h"

namespace tandem::bench {

/// The main() of work_precision_<engine>: one scene, one engine, one setting; measures the time of
/// a frame and the error of the result. run.py runs them all.
int work_precision_main(int argc, char** argv, const MakeEngine& make);

}  // namespace tandem::bench
