// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ranks.h"

namespace tandem::mpi {

/// One file that all ranks write at the same time, each its own section, and that any number of
/// ranks reads. Head: magic, sections, steps, step length's sum; of each section place, size and
/// hash; a hash of all that.
struct Checkpoint {
  std::uint64_t steps = 0;
  std::vector<Bytes> sections;  ///< those that this rank has written, or reads
};

/// @throws std::runtime_error on all ranks where a file cannot be written; what was there stays
void write_checkpoint(Ranks& ranks, const std::string& path, std::uint64_t steps,
                      const Bytes& section);
/// Section s is read by rank s modulo their number.
/// @throws std::runtime_error on all ranks where it is none, or damaged
Checkpoint read_checkpoint(Ranks& ranks, const std::string& path);

}  // namespace tandem::mpi
