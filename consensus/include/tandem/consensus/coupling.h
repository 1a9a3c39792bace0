// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::consensus {

/// What remote states do to the bodies here. OnePass is what this library is about; the others are
/// what it is compared with, on the same engine and behind the same prediction and rules of
/// influence. Bodies that have an owner from the start (ShareDef::owner) follow their owner in all
/// of them: like a user's spring they are an input, not a matter of agreement.
enum class Coupling : std::uint8_t {
  OnePass,  ///< remote states are targets in the solver's pass
  TwoStep,  ///< the paper's scheme: average first, [friston] Secs. 4.2 and 4.6, then a plain step
  None,     ///< states are sent and never used: what copies do that only users' springs join
  /// Transactional: a body belongs to one peer, the others put it where its owner has it. It passes
  /// to whoever acts on it last, by a request and a grant, a round trip after the act; what nobody
  /// has asked for is the lowest id's.
  SingleOwner,
};

}  // namespace tandem::consensus
