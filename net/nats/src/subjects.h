// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"

namespace tandem::nats {

/// Names of a session's subjects:
///   PREFIX.SCENE.to.PEER             datagrams for a peer
///   PREFIX.SCENE.who.PATH            who is in a cell of level 0
///   PREFIX.SCENE.sum.LEVEL.PATH      what a cell of that level comes to
/// PATH is the cell's from the top level down, so that a wildcard stands for a larger one.
class Subjects {
 public:
  Subjects(std::string_view prefix, std::uint64_t scene_hash, const CellOptions& cells);

  std::string to(consensus::PeerId peer) const;
  std::string who(const Cell& cell) const;
  /// For all cells of level 0 in one of level 1.
  std::string who_within(const Cell& cell) const { return base_ + "who." + path(cell) + ".*"; }
  std::string summary(const Cell& cell) const;
  /// For the cells of the level below in this one.
  std::string summaries_within(const Cell& cell) const;

  /// Tokens from the top level down to this cell.
  std::string path(const Cell& cell) const;
  const std::string& base() const { return base_; }

 private:
  CellOptions cells_;
  std::string base_;
};

/// For a stream of a session: names of streams have no dots.
std::string stream_name(std::string base, std::string_view kind);

/// Sixteen hex digits.
std::string hex(std::uint64_t value);

/// Whether a word may stand in a subject: 1 to 64 letters, digits, - and _.
bool is_token(std::string_view word);

}  // namespace tandem::nats
