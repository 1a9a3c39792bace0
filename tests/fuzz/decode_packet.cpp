// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What tandem::consensus reads of a peer's packets.
#include "tandem/consensus/update.h"
#include "target.h"

namespace fuzz {

using namespace tandem::consensus;

void run(std::span<const std::byte> input) {
  DecodedPacket packet;
  const bool ok = decode(input, packet).ok();
  if (!ok) require(packet.states.empty() && packet.springs.empty() && packet.leaves.empty());
  for (const StateUpdate& state : packet.states) require(check(state).ok());
  for (const SpringUpdate& spring : packet.springs) require(check(spring).ok());
  for (const ActUpdate& act : packet.acts) require(check(act).ok());
  for (const ActReceipt& receipt : packet.receipts) require(check(receipt).ok());
  for (const Leave& leave : packet.leaves) require(check(leave).ok());
}

std::vector<Bytes> seeds() {
  Bytes leave;
  (void)encode(Leave{.stamp = 5}, leave);
  StateUpdate state;
  state.id = SharedId::from_name("a body");
  Bytes states;
  (void)encode(std::span<const StateUpdate>(&state, 1), states);
  Bytes both = states;
  both.insert(both.end(), leave.begin(), leave.end());
  const ActUpdate act{.body = state.id, .pose = tandem::pbd::Pose{}, .stamp = 5};
  const ActReceipt receipt{.actor = 1, .body = state.id, .stamp = 5};
  Bytes acts;
  (void)encode(std::span<const ActUpdate>(&act, 1), acts);
  (void)encode(std::span<const ActReceipt>(&receipt, 1), acts);
  return {leave, states, both, acts};
}

}  // namespace fuzz
