// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

class World;

struct TANDEM_API SmoothPosesOptions {
  /// s, >= 0: what agreement and small jumps move is shown little by little, e times less after
  /// each such time; 0 shows it as it happens. Two users, one cube, link profile 5: the longest
  /// jump at 144 Hz is 4 mm instead of 19 (tests/consensus/smooth_poses_test.cpp).
  double blend = 0.1;
  double snap = 1.0;  ///< m, > 0: longer jumps are shown at once
};

/// Where to draw bodies between steps, for displays of any rate:
///
///     SmoothPoses shown;
///     while (step_is_due) { solver.step(world, dt); shown.after_step(world, dt); }
///     draw(shown.at(body, alpha));  // alpha = time since the last step was due / dt
///
/// What is drawn is a step late and lies between the last two steps. With a Session, alpha is
/// Progress::lag over the length of a step. Where other peers have moved a body
/// (World::correction()) or it was put somewhere, what is drawn goes on as it went and blends over;
/// after that, and where nothing does, alpha 1 is the world's own pose. Poses are those of
/// World::pose(). Nothing here changes the world.
/// @par Thread safety  A value: as a container.
class TANDEM_API SmoothPoses {
 public:
  /// @throws std::invalid_argument naming field, value and rule
  explicit SmoothPoses(const SmoothPosesOptions& options = {});

  /// Take over all bodies, after each step of `dt` (s, > 0). Allocates where there are more slots
  /// than ever.
  void after_step(const World& world, double dt);
  /// @param alpha  0, the step before the last, to 1, the last one; cut to that
  /// @throws std::invalid_argument  where the last after_step() saw no such body
  Pose at(BodyId body, double alpha) const;

 private:
  struct Shown {
    BodyId body;
    BodyState world;  ///< after the last step
    Pose before, now;
    /// What is drawn is this much behind the world's pose; turned first, then moved.
    Vec3 behind = Vec3::Zero();  ///< m, world
    Quat behind_turn = Quat::Identity();
  };
  void take(Shown& shown, const World& world, double dt, double keeps) const;

  SmoothPosesOptions options_;
  std::vector<Shown> shown_;  ///< by slot
};

}  // namespace tandem::pbd
