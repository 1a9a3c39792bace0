// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/scenario.h"

namespace tandem::demos {

/// Measures of the scene "stacked cubes", after [friston] Sec. 5.5.
struct CubesOptions {
  int stacks = 4;                               ///< on the plate
  int height = 4;                               ///< cubes in each of them, and in the pillar
  double edge = 0.1;                            ///< m, of a cube
  double cube_mass = 0.3;                       ///< kg
  double plate_mass = 4.0;                      ///< kg
  pbd::Vec3 plate = pbd::Vec3(1.6, 0.8, 0.04);  ///< m
  double friction = 0.55;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Stacks of cubes on a plate that lies on the ground at the origin, its long side along x; beside
/// it the pillar, a stack on the ground that nobody touches. Names: "plate", "cube/<stack>/<level>"
/// from -x to +x and from below, "pillar/<level>".
///
/// User A pulls a cube out of the first stack, off the plate towards -y, and so throws the stack
/// over; user B carries the topmost cube of the last stack to the ground. Then both lift the plate
/// with what stands on it, one at each end, carry it sideways, set it down and let go; in longer
/// sessions they carry it back, and so on.
class CubesScenario final : public Scenario {
 public:
  /// s: the first lift begins; a lift with its rest takes kLiftPeriod.
  static constexpr double kLiftStart = 8.0;
  static constexpr double kLiftPeriod = 10.0;

  /// @throws std::invalid_argument where the options are not valid
  explicit CubesScenario(const CubesOptions& options = {});

  const CubesOptions& options() const { return options_; }
  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  /// The pillar stands: no cube has moved by 5 mm or tilted by 2 degrees.
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
