// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What another engine needs that steps the bodies in place of pbd::Solver.
#include "peer_impl.h"

namespace tandem::consensus {

void Springs::pulls(std::vector<pbd::Tether::Def>& out) const {
  const auto add = [&](pbd::ConstraintId tether) {
    if (tethers_.contains(tether)) out.push_back(tethers_.def(tether));
  };
  for (const Own& own : own_) add(own.tether);
  for (const Remote& remote : remote_) {
    if (remote.live) add(remote.tether);
  }
}

void Peer::Impl::note_contact(pbd::BodyId a, pbd::BodyId b) {
  for (const auto& [body, other] : {std::pair(a, b), std::pair(b, a)}) {
    if (world_.contains(body)) noted_contacts_.emplace_back(body.index, other.index);
  }
}

void Peer::Impl::mark_noted_contacts() {
  for (const auto& [body, other] : noted_contacts_) {
    const std::uint8_t by = other < touching_.size() ? touching_[other] : std::uint8_t{0};
    if (body < acting_.size())
      acting_[body] = static_cast<std::uint8_t>(acting_[body] | kTouched | by);
  }
  noted_contacts_.clear();
}

}  // namespace tandem::consensus
