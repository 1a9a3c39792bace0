// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "scenes/inputs.h"
#include "tandem/pbd/bytes.h"

namespace tandem::rollback_bench {

/// The input of one peer for one frame: what its users do, in order. The frame says when it is, not
/// their times.
using Inputs = std::vector<demos::Input>;

/// Positions and strengths as floats, orientations in 16 bits each: 15 bytes for a spring that
/// moves.
void write(pbd::ByteWriter& out, const Inputs& inputs);
/// What cannot be read makes the reader fail.
Inputs read(pbd::ByteReader& in);
/// As the others will read them: all peers must simulate the same bits.
Inputs rounded(const Inputs& inputs);
/// Whether the same is done, in whatever order.
bool same(const Inputs& a, const Inputs& b);

}  // namespace tandem::rollback_bench
