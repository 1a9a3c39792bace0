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

/// What the other peers call their bodies. A state whose index or table is not known here belongs
/// to no body: it is never guessed whose it is. It takes what is said, up to a limit for each peer,
/// and is kept for those that are connected.
class IndexTables {
 public:
  /// @param most  names of one peer; further ones are not learnt
  void learn(PeerId from, const IndexAssignment& name, std::size_t most);
  /// The body of a state; null where its name has not come. Valid until the next learn().
  const SharedId* find(PeerId from, const CompactState& state) const;
  void forget(PeerId from);
  /// After the states of a packet. @param missed  some had no name
  /// @return whether it is time to ask for the names: some have been missing for a while
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

  /// Made where there is none. Valid until the next one comes or goes.
  Table& table_of(PeerId from);

  std::vector<Table> tables_;
};

}  // namespace tandem::consensus
