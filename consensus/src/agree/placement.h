// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "agree/estimates.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Puts bodies where others have them: an owner's jumps, and newcomers'.
class Placement {
 public:
  explicit Placement(PeerData& data) : data_(data) {}

  /// Put a body where it is said to be, whatever is in between.
  void place(SharedBody& shared, const pbd::BodyState& state);
  /// A newcomer took over what it heard first, which may have been false: put its body where the
  /// majority of several has it.
  void give_way(SharedBody& shared, const Estimates& estimates);
  /// After a step of `dt` s: whether the body was put somewhere else since the last one.
  void note_step(SharedBody& shared, double dt) const;

 private:
  bool jumps(const SharedBody& shared, const pbd::Correction& correction, double dt) const;

  PeerData& data_;
};

}  // namespace tandem::consensus
