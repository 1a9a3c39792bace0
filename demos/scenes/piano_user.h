// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>

#include "scenes/piano.h"
#include "scenes/random.h"

namespace tandem::demos {

/// One of two users who move the piano. They grasp their end and follow the path through the maze
/// no faster than the seen piano. The hand's end of the spring is a haptic device's pen or the
/// mouse cursor.
class PianoUser final : public User {
 public:
  PianoUser(std::size_t user, const PianoOptions& piano, Controls& controls,
            const UserOptions& options);
  void update(consensus::SessionTime now) override;
  Outcome outcome() const override;
  std::vector<Series> series() const override { return {energy_, force_}; }

 private:
  static constexpr double kGraspAt = 1.5;  ///< s
  static constexpr double kGoAt = 2.5;
  static constexpr double kLead = 0.7;  ///< s, lead of the hand over the seen piano

  pbd::Vec3 meant(double time);
  void follow_progress(double time);
  void take_hold();

  std::size_t user_;
  PianoOptions piano_;
  Controls& controls_;
  std::size_t body_;
  Sight sight_;
  Tremor tremor_;
  PianoPath path_;
  pbd::Vec3 home_;  ///< m, the hand's waiting position
  HapticDevice device_;
  std::optional<std::uint32_t> spring_;
  std::optional<HapticPoint> proxy_;  ///< of the last frame
  Series energy_;                     ///< J, of the passivity observer
  Series force_;                      ///< N, of the motors
  double last_ = -1.0;                ///< s, time of the last update
  double progress_ = 0.0;             ///< s on the path, of the hand
  double seen_progress_ = 0.0;        ///< s on the path, of the seen piano
  double done_at_ = -1.0;             ///< s
};

}  // namespace tandem::demos
