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

/// A user whose one hand does what a record has, by the springs of a room's page.
///
/// It holds the scene's body of the recorded name. Where there is none, the n-th new name of the
/// record is number n * users + user of what hands may hold there, and after the last comes the
/// first. It holds it at the recorded point, or where that is outside, at the nearest one of the
/// box about the body. From there it moves as the recorded hand did from where that one grabbed,
/// times the scene's scale; both as axes of the world have it.
class RecordedHand final : public User {
 public:
  static constexpr double kPatience = 0.5;  ///< s: later than this a hold is left out
  // As the page has it (tools/room/page/hand.js).
  static constexpr double kLowest = 0.02;    ///< m, above the ground
  static constexpr double kStrength = 40.0;  ///< N/kg
  static constexpr double kFullAt = 0.04;    ///< m, from where on it pulls with all its force
  static constexpr double kDampingRatio = 0.7;

  /// The controls must outlive it.
  /// @throws std::invalid_argument where there is nothing that hands may hold
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
  std::vector<std::size_t> bodies_;  ///< of each hold: index into Scene::bodies
  std::size_t next_ = 0;             ///< the hold that is on, or is to come
  bool closed_ = false;
  std::size_t done_ = 0;                        ///< holds carried through
  std::optional<std::uint32_t> spring_;         ///< of Controls
  pbd::Vec3 attachment_l_ = pbd::Vec3::Zero();  ///< m, frame of the body
  pbd::Vec3 grabbed_w_ = pbd::Vec3::Zero();     ///< m, world: where the hand grabbed
  PointerHand hand_;
};

}  // namespace tandem::demos
