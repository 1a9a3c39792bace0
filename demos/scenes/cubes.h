// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/scenario.h"

namespace tandem::demos {

/// Dimensions of the scene "stacked cubes", after [friston] Sec. 5.5.
struct CubesOptions {
  int stacks = 4;                               ///< on the plate
  int height = 4;                               ///< cubes per stack, and in the pillar
  double edge = 0.1;                            ///< m, of a cube
  double cube_mass = 0.3;                       ///< kg
  double plate_mass = 4.0;                      ///< kg
  pbd::Vec3 plate = pbd::Vec3(1.6, 0.8, 0.04);  ///< m
  double friction = 0.55;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Stacks of cubes on a plate, which lies on the ground at the origin with its long side along x;
/// beside it the pillar, a stack that nobody touches. Names: "plate", "cube/<stack>/<level>" from
/// -x to +x and bottom to top, "pillar/<level>".
///
/// User A topples the first stack by pulling a cube towards -y; user B carries the top cube of the
/// last stack to the ground. Then both lift the plate at its ends, carry it sideways and set it
/// down; longer sessions repeat this back and forth.
class CubesScenario final : public Scenario {
 public:
  /// s: start of the first lift; a lift with its rest takes kLiftPeriod.
  static constexpr double kLiftStart = 8.0;
  static constexpr double kLiftPeriod = 10.0;

  /// @throws std::invalid_argument if the options are not valid
  explicit CubesScenario(const CubesOptions& options = {});

  const CubesOptions& options() const { return options_; }
  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  /// Fault: a cube of the pillar moved by 5 mm or tilted by 2 degrees.
  std::string fault(const Scene& scene) const override;
  /// All but the pillar.
  std::vector<std::size_t> holdable(const Scene& scene) const override {
    return unowned(scene, "pillar/");
  }
  std::unique_ptr<Referee> make_referee(const Scene& scene) const override;
  Achievement achievement(const Outcome& outcome) const override;

 private:
  CubesOptions options_;
};

}  // namespace tandem::demos
