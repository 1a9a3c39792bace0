// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "scenes/inputs.h"
#include "tandem/pbd/bytes.h"

namespace tandem::rollback_bench {

/// One peer's input for one frame: its users' actions, in order, without times.
using Inputs = std::vector<demos::Input>;

/// Positions and strengths as floats, orientations in 16 bits each: 15 bytes for a moving spring.
void write(pbd::ByteWriter& out, const Inputs& inputs);
/// Invalid bytes make the reader fail.
Inputs read(pbd::ByteReader& in);
/// As the others will read them: all peers must simulate the same bits.
Inputs rounded(const Inputs& inputs);
/// True if the inputs are equal, in any order.
bool same(const Inputs& a, const Inputs& b);

}  // namespace tandem::rollback_bench
