// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ranks.h"

namespace tandem::mpi {

/// One file that all ranks write at the same time, each its own section, and that any number of
/// ranks reads. Head: magic, sections, steps, sum of step lengths; place, size and hash of each
/// section; a hash of all that.
struct Checkpoint {
  std::uint64_t steps = 0;
  std::vector<Bytes> sections;  ///< those that this rank writes or reads
};

/// @throws std::runtime_error on all ranks if a file cannot be written; an earlier one stays
void write_checkpoint(Ranks& ranks, const std::string& path, std::uint64_t steps,
                      const Bytes& section);
/// Rank r reads the sections s with s modulo the number of ranks = r.
/// @throws std::runtime_error on all ranks if it is no checkpoint, or damaged
Checkpoint read_checkpoint(Ranks& ranks, const std::string& path);

}  // namespace tandem::mpi
