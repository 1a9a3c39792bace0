// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::pbd {

/// Pose of a kinematic body after the next step.
struct TANDEM_API KinematicTarget {
  std::uint32_t index = 0;  ///< slot
  Pose pose = {};           ///< m, world
};

/// At most one target per body, found by the body's slot.
class TANDEM_API KinematicTargets {
 public:
  std::span<const KinematicTarget> all() const { return targets_; }
  std::optional<Pose> pose_of(std::uint32_t index) const {
    return has(index) ? std::optional(targets_[places_[index]].pose) : std::nullopt;
  }
  void set(const KinematicTarget& target) {
    if (has(target.index)) {
      targets_[places_[target.index]] = target;
      return;
    }
    if (target.index >= places_.size()) places_.resize(target.index + std::size_t{1});
    places_[target.index] = static_cast<std::uint32_t>(targets_.size());
    targets_.push_back(target);
  }
  void remove(std::uint32_t index) {
    if (!has(index)) return;
    const std::uint32_t place = places_[index];
    targets_[place] = targets_.back();
    places_[targets_[place].index] = place;
    targets_.pop_back();
  }
  void clear() { targets_.clear(); }

 private:
  bool has(std::uint32_t index) const {
    return index < places_.size() && places_[index] < targets_.size() &&
           targets_[places_[index]].index == index;
  }

  std::vector<KinematicTarget> targets_;
  std::vector<std::uint32_t> places_;  ///< by slot, into targets_; valid if it names the slot
};

}  // namespace tandem::pbd
