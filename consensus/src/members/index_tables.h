// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/consensus/shared_id.h"
#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"

namespace tandem::consensus {

/// The other peers' indices of bodies. A state with an unknown index or table belongs to no body:
/// there is no guessing. The tables are bounded per peer, and kept for those connected.
class IndexTables {
 public:
  /// @param most  names of one peer; further ones are ignored
  void learn(PeerId from, const IndexAssignment& name, std::size_t most);
  /// The body of a state; null if its index is unknown. Valid until the next learn().
  const SharedId* find(PeerId from, const CompactState& state) const;
  void forget(PeerId from);
  /// Call after the states of a packet. @param missed  some had an unknown index
  /// @return whether it is time to ask for the indices: some have been missing for a while
  bool should_ask(PeerId from, bool missed, SessionTime now);

 private:
  struct Name {
    std::uint16_t index = 0;
    SharedId id;
  };
  struct Table {
    PeerId peer = 0;
    std::uint32_t number = 0;
    std::vector<Name> names;  ///< by index
    SessionTime missing_since = 0;
  };

  /// Creates a missing table. Valid until a table is added or removed.
  Table& table_of(PeerId from);

  std::vector<Table> tables_;
};

}  // namespace tandem::consensus
