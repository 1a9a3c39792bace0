// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>

#include "input/hand_filter.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// A user's hand as announced: its past positions, and its extrapolation.
class HandTrack {
 public:
  /// Hand at one time.
  struct Place {
    pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world
    pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s
  };

  void clear() { count_ = 0; }
  /// @param velocity  m/s, as announced: of that time, and used if a motion begins
  void add(SessionTime stamp, const pbd::Vec3& position, const pbd::Vec3& velocity);
  bool empty() const { return count_ == 0; }
  /// ns, of the last announcement.
  SessionTime newest() const { return sample(0).stamp; }
  /// At newest(), to be extrapolated from there.
  const HandFilter::Motion& motion() const { return filter_.motion(); }
  /// At an earlier time, interpolated between announcements; the first one before all of them.
  Place at(SessionTime time) const;

 private:
  struct Sample {
    SessionTime stamp = 0;
    Place place;
  };
  static constexpr std::size_t kMaxSamples = 16;

  /// By age; 0 = the newest.
  const Sample& sample(std::size_t age) const {
    return samples_[(end_ + kMaxSamples - 1 - age) % kMaxSamples];
  }

  std::array<Sample, kMaxSamples> samples_;
  std::size_t end_ = 0;
  std::size_t count_ = 0;
  HandFilter filter_;
};

}  // namespace tandem::consensus
