// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/replay_tethers.h"

#include <algorithm>

#include "common/session_time.h"

namespace tandem::consensus {

void ReplayTethers::begin(const pbd::World& world, pbd::World& scratch,
                          std::span<const pbd::ConstraintId> rows, SessionTime known_until) {
  known_until_ = known_until;
  const auto blocks = world.blocks();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].get() != &springs_.block()) continue;
    tethers_ = static_cast<pbd::Tethers*>(scratch.blocks()[i].get());
  }
  for (const pbd::ConstraintId id : rows) {
    if (tethers_->contains(id)) tethers_->remove(id);
  }
  rows_.clear();
}

void ReplayTethers::apply(pbd::World& scratch, SessionTime time, double dt) {
  pulls_.clear();
  const bool late = inputs_ == ReplayInputs::Common && time > known_until_;
  const WorldHistory::Frame& frame =
      history_.frame(history_.at_or_before(late ? known_until_ : time));
  for (const Pull& own : frame.pulls) {
    pbd::Tether::Def& def = pulls_.emplace_back(own.def);
    if (late) springs_.carry_on(own.told, seconds(time - frame.time), def);
  }
  springs_.others_at(scratch, time, dt, pulls_);
  std::erase_if(pulls_, [&](const auto& def) { return !scratch.contains(def.body); });
  const bool same =
      pulls_.size() == rows_.size() && std::equal(pulls_.begin(), pulls_.end(), rows_.begin(),
                                                  [this](const auto& def, pbd::ConstraintId row) {
                                                    return tethers_->contains(row) &&
                                                           tethers_->def(row).body == def.body;
                                                  });
  if (!same) {
    for (const pbd::ConstraintId row : rows_) {
      if (tethers_->contains(row)) tethers_->remove(row);
    }
    rows_.clear();
    for (const auto& def : pulls_) rows_.push_back(tethers_->add(scratch, def));
    return;
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) tethers_->set(scratch, rows_[i], pulls_[i]);
}

}  // namespace tandem::consensus
