// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "agree/estimates.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Places bodies where others have them: for owners' jumps, and at newcomers.
class Placement {
 public:
  explicit Placement(PeerData& data) : data_(data) {}

  /// Place a body, whatever is in the way.
  void place(SharedBody& shared, const pbd::BodyState& state);
  /// A newcomer's first state may have been false: place its body where the majority of several
  /// peers has it.
  void give_way(SharedBody& shared, const Estimates& estimates);
  /// After a step of `dt` s: detect whether the body was placed since the last one.
  void note_step(SharedBody& shared, double dt) const;

 private:
  bool jumps(const SharedBody& shared, const pbd::Correction& correction, double dt) const;

  PeerData& data_;
};

}  // namespace tandem::consensus
