// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// Where a user's hand was, as it was told, and where it may go from there: on the parabola that is
/// nearest to what it did last, by least squares.
class HandTrack {
 public:
  struct Motion {
    pbd::Vec3 position = pbd::Vec3::Zero();      ///< m, world
    pbd::Vec3 velocity = pbd::Vec3::Zero();      ///< m/s
    pbd::Vec3 acceleration = pbd::Vec3::Zero();  ///< m/s^2
  };

  void clear() { count_ = 0; }
  /// @param velocity  m/s, as it was told: what counts until a parabola can be laid
  void add(SessionTime stamp, const pbd::Vec3& position, const pbd::Vec3& velocity);
  bool empty() const { return count_ == 0; }
  /// ns, of what was told last.
  SessionTime newest() const { return sample(0).stamp; }
  /// At newest(): what is carried on from there.
  const Motion& motion() const { return motion_; }
  /// At an earlier time, between what was told; before all of it as at first.
  Motion at(SessionTime time) const;

 private:
  struct Sample {
    SessionTime stamp = 0;
    pbd::Vec3 position = pbd::Vec3::Zero();
    pbd::Vec3 velocity = pbd::Vec3::Zero();
  };
  static constexpr std::size_t kMaxSamples = 16;

  /// By age, 0 = the newest.
  const Sample& sample(std::size_t age) const {
    return samples_[(end_ + kMaxSamples - 1 - age) % kMaxSamples];
  }
  /// Lay the parabola through the last `window` s.
  /// @return m, rms of what it misses; infinity where there is too little to go by
  double fit(double window);

  std::array<Sample, kMaxSamples> samples_;
  std::size_t end_ = 0;
  std::size_t count_ = 0;
  Motion motion_;
};

}  // namespace tandem::consensus
