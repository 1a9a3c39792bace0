// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "message.h"

namespace tandem::mpi {

/// A rank's inputs in order, so that it can be replayed alone: see ClusterOptions::record.
class Tape {
 public:
  /// Neither records nor replays.
  Tape() = default;
  /// @throws std::runtime_error if a file cannot be opened, or is no tape
  void record(const std::string& path, int rank, int count);
  void replay(const std::string& path);

  bool records() const { return out_.is_open(); }
  bool replays() const { return replays_; }
  int rank() const { return rank_; }
  int count() const { return count_; }

  void write(std::span<const std::byte> bytes);
  /// The next record that was given to write().
  void read(Bytes& bytes);

 private:
  std::ofstream out_;
  Bytes all_;  ///< of the replayed tape
  std::size_t at_ = 0;
  bool replays_ = false;
  int rank_ = 0;
  int count_ = 1;
};

}  // namespace tandem::mpi
