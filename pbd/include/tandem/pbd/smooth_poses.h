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
  /// s, >= 0: time constant, in which displacements by agreement and small jumps fade by a factor
  /// e; 0 shows them at once. Two users, one cube, link profile 5: the longest jump at 144 Hz is 4
  /// mm instead of 19 (tests/consensus/smooth_poses_test.cpp).
  double blend = 0.1;
  double snap = 1.0;  ///< m, > 0: longer jumps are shown at once
};

/// Interpolated poses for drawing at any display rate:
///
///     SmoothPoses shown;
///     while (step_is_due) { solver.step(world, dt); shown.after_step(world, dt); }
///     draw(shown.at(body, alpha));  // alpha = time since the last step was due / dt
///
/// The drawn pose lies between the last two steps, one step late. With a Session, alpha is
/// Progress::lag over the length of a step. If other peers moved a body (World::correction()) or it
/// was placed, the drawn pose continues its motion and blends over; otherwise alpha 1 is the
/// world's own pose. Poses are those of World::pose(). The world is not changed.
/// @par Thread safety  A value: as a container.
class TANDEM_API SmoothPoses {
 public:
  /// @throws std::invalid_argument naming field, value and rule
  explicit SmoothPoses(const SmoothPosesOptions& options = {});

  /// Call after each step of `dt` (s, > 0). Allocates if there are more slots than ever before.
  void after_step(const World& world, double dt);
  /// @param alpha  0, the step before the last, to 1, the last one; clamped
  /// @throws std::invalid_argument  if the last after_step() saw no such body
  Pose at(BodyId body, double alpha) const;

 private:
  struct Shown {
    BodyId body;
    BodyState world;  ///< after the last step
    Pose before, now;
    /// Offset of the drawn pose from the world's: turned first, then moved.
    Vec3 behind = Vec3::Zero();  ///< m, world
    Quat behind_turn = Quat::Identity();
  };
  void take(Shown& shown, const World& world, double dt, double keeps) const;

  SmoothPosesOptions options_;
  std::vector<Shown> shown_;  ///< by slot
};

}  // namespace tandem::pbd
