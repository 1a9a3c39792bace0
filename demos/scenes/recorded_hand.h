// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "scenes/hand_record.h"
#include "scenes/pointer_hand.h"
#include "scenes/scenario.h"

namespace tandem::demos {

/// A user whose one hand replays a record, with the springs of a room's page.
///
/// It holds the scene's body of the recorded name. Otherwise the record's n-th new name becomes
/// number n * users + user of the holdable bodies, cyclically. It holds the body at the recorded
/// point, or at the nearest point of its bounding box, and moves as the recorded hand did from its
/// grab, times the scene's scale, along the world's axes.
class RecordedHand final : public User {
 public:
  static constexpr double kPatience = 0.5;  ///< s: a hold that is later is skipped
  // The same values as the page (tools/room/page/hand.js).
  static constexpr double kLowest = 0.02;    ///< m, above the ground
  static constexpr double kStrength = 40.0;  ///< N/kg
  static constexpr double kFullAt = 0.04;    ///< m, stretch at maximum force
  static constexpr double kDampingRatio = 0.7;

  /// The controls must outlive it.
  /// @throws std::invalid_argument if the scene has nothing to hold
  RecordedHand(std::size_t user, const Scenario& scenario, Controls& controls, HandRecord record);
  void update(consensus::SessionTime now) override;
  Outcome outcome() const override;

 private:
  void close(std::size_t body, const HandRecord::Hold& hold);
  void follow(const HandRecord::Hold& hold, double time);
  void open();

  Controls& controls_;
  HandRecord record_;
  pbd::Vec3 scale_;
  std::vector<std::size_t> bodies_;  ///< per hold: index into Scene::bodies
  std::size_t next_ = 0;             ///< the present or next hold
  bool closed_ = false;
  std::size_t done_ = 0;                        ///< completed holds
  std::optional<std::uint32_t> spring_;         ///< of Controls
  pbd::Vec3 attachment_l_ = pbd::Vec3::Zero();  ///< m, frame of the body
  pbd::Vec3 grabbed_w_ = pbd::Vec3::Zero();     ///< m, world: the hand at the grab
  PointerHand hand_;
};

}  // namespace tandem::demos
