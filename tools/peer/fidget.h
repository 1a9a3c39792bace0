// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "scenes/hand.h"
#include "scenes/inputs.h"
#include "scenes/random.h"
#include "scenes/scene.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos {

/// Somebody who cannot leave things alone: grabs a body near the hand, lifts and moves it, lets go,
/// waits, and so on for ever. Bodies stay within kReach of where they began. For soaks: what it
/// does is kept until the next step alone, so that memory does not grow.
/// @par Thread safety  One object: the thread of its peer.
class Fidget {
 public:
  static constexpr double kReach = 0.5;  ///< m

  /// Both must outlive it.
  Fidget(const Scene& scene, consensus::Peer& peer, std::uint64_t seed);

  /// Before each step. @param now  ns, session time; grows
  void update(consensus::SessionTime now);
  /// Nobody else's number.
  static constexpr std::uint32_t kUser = UINT32_MAX;
  /// What the last update() has done, as user kUser.
  std::span<const Input> inputs() const { return inputs_; }
  /// Bodies that were taken and put down again.
  std::uint64_t done() const { return done_; }

 private:
  void grab(double time);
  void let_go(double time);
  void note(Input::Kind kind, std::vector<double> values);

  const Scene& scene_;
  consensus::Peer& peer_;
  Random random_;
  std::vector<std::size_t> bodies_;  ///< that may be taken
  std::optional<consensus::SessionTime> start_;
  double next_ = 0.0;  ///< s since the start, when something is taken again
  std::optional<std::size_t> body_;
  consensus::GrabId spring_;
  std::optional<HandPath> path_;
  std::uint64_t done_ = 0;
  std::uint32_t grabs_ = 0;  ///< how often something was grabbed
  std::vector<Input> inputs_;
};

}  // namespace tandem::demos
