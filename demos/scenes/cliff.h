// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/scenario.h"

namespace tandem::demos {

/// A thousand balls fall over a cliff of triangles, after [friston] Sec. 5.1. They are held in the
/// air until user A presses a key, which reaches all peers as a signal. Walls keep them in. Names:
/// "ball/<number>".
class CliffScenario final : public Scenario {
 public:
  static constexpr double kPress = 1.0;  ///< s: the key is pressed
  /// s from the key to the fall, so that peers across an ocean release at the same time. After a
  /// later signal the balls start from where they would be by then.
  static constexpr double kLead = 0.2;

  /// @param balls  at most a thousand
  /// @throws std::invalid_argument if the number is not within 1 to 1000
  explicit CliffScenario(int balls = 1000);

  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  void on_signal(Scene& scene, const Signal& signal, consensus::SessionTime now) const override;
  Bounds bounds() const override { return {.max_distance = 25.0, .max_speed = 20.0, .lowest = -1}; }
  /// Fault: a ball under the ground or behind a wall.
  std::string fault(const Scene& scene) const override;
  std::unique_ptr<Referee> make_referee(const Scene& scene) const override;
  Achievement achievement(const Outcome& outcome) const override;

 private:
  int balls_;
};

}  // namespace tandem::demos
