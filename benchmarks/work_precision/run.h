// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "demos/engine/engine.h"

namespace tandem::bench {

/// The main() of work_precision_<engine>: time of a frame and error of the result for one scene and
/// setting. run.py runs them all.
int work_precision_main(int argc, char** argv, const MakeEngine& make);

}  // namespace tandem::bench
