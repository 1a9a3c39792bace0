// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scenes/controls.h"
#include "scenes/hand.h"
#include "scenes/random.h"
#include "scenes/user.h"

namespace tandem::demos {

/// A restless user for soak tests: grabs a body near the hand, moves it, releases it, waits, and
/// repeats for ever. Bodies stay within kReach of their start.
/// @par Thread safety  One object: the thread of its peer.
class Fidget final : public User {
 public:
  static constexpr double kReach = 0.5;               ///< m
  static constexpr std::uint32_t kUser = UINT32_MAX;  ///< not used elsewhere

  /// Must outlive it.
  Fidget(Controls& controls, std::uint64_t seed);

  void update(consensus::SessionTime now) override;
  /// Number of bodies moved.
  std::uint64_t done() const { return done_; }

 private:
  void grab(double time);
  void let_go(double time);

  Controls& controls_;
  Random random_;
  std::vector<std::size_t> bodies_;  ///< holdable ones
  double next_ = 0.0;                ///< s since the epoch, of the next grab
  std::optional<std::size_t> body_;
  std::uint32_t spring_ = 0;
  std::optional<HandPath> path_;
  std::uint64_t done_ = 0;
};

}  // namespace tandem::demos
