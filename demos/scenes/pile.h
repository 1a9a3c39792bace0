// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "scenes/scenario.h"

namespace tandem::demos {

/// Dimensions of the scene "pile".
struct PileOptions {
  int rows = 30;           ///< small cubes in each direction
  double edge = 0.1;       ///< m, of a small cube
  double pitch = 0.14;     ///< m, between their centres at the start
  double big_edge = 0.5;   ///< m
  double density = 100.0;  ///< kg/m^3
  double friction = 0.5;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Small cubes in a square on the ground around the origin, and a big one beside them: 901 bodies
/// (docs/history/network-figures.md). Names: "big", "small/<row>/<column>".
///
/// Both users hold the big cube at the ends of an axis that it can turn about, and roll it through
/// the small ones and back.
class PileScenario final : public Scenario {
 public:
  static constexpr double kStart = 1.5;  ///< s, first roll
  static constexpr double kRoll = 6.0;   ///< s, one way
  static constexpr double kBack = 10.0;  ///< s, roll back

  /// @throws std::invalid_argument if the options are not valid
  explicit PileScenario(const PileOptions& options = {});

  const PileOptions& options() const { return options_; }
  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  std::unique_ptr<Referee> make_referee(const Scene& scene) const override;
  Achievement achievement(const Outcome& outcome) const override;

 private:
  PileOptions options_;
};

}  // namespace tandem::demos
