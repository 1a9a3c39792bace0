// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <vector>

#include "scenes/haptic_device.h"
#include "scenes/scenario.h"

namespace tandem::demos {

struct PianoOptions {
  /// Springs are sent to all peers; otherwise each is known to its user's peer alone.
  bool soft = false;
  bool mouse = false;  ///< user B has a mouse, not a haptic device
  bool tug = false;    ///< no steering: the users pull against each other
  HapticOptions device;

  /// "" = two haptic devices, asymmetric; otherwise any of soft, mouse, tug joined by -.
  /// @return false if there is no such variant
  static bool parse(const std::string& variant, PianoOptions& options);
};

/// Seen from above.
struct PianoPose {
  double x = 0.0, y = 0.0;  ///< m
  double angle = 0.0;       ///< rad, of its long axis against x
};

/// Two users carry a small piano through a maze on a desk, after [friston] Sec. 5.4. Each grasps
/// one end by a single spring, so that neither can turn it alone; it rolls on castors. Name:
/// "piano".
class PianoScenario final : public Scenario {
 public:
  explicit PianoScenario(const PianoOptions& options = {})
      : Scenario("piano", 2), options_(options) {}

  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  Bounds bounds() const override { return {.max_distance = 2.0, .max_speed = 5.0, .lowest = 0.0}; }
  /// Fault: the piano outside the walls.
  std::string fault(const Scene& scene) const override;
  std::vector<std::size_t> holdable(const Scene& scene) const override { return unowned(scene); }
  /// A sixth of the size of the room page's piano, and it rolls.
  pbd::Vec3 hand_scale() const override { return {1.0 / 6.0, 1.0 / 6.0, 0.0}; }
  std::unique_ptr<Referee> make_referee(const Scene& scene) const override;
  Achievement achievement(const Outcome& outcome) const override;
  std::string_view baseline() const override { return "single-owner"; }

 private:
  PianoOptions options_;
};

inline constexpr double kPianoArenaX = 0.42;  ///< m, half the maze
inline constexpr double kPianoArenaY = 0.27;
/// m: two walls, the first from -y and the second from +y, end in the middle; half thickness:
inline constexpr double kPianoWallX[2] = {-0.14, 0.15};
inline constexpr double kPianoWallHalf = 0.01;
inline constexpr double kPianoMass = 0.4;  ///< kg

/// m, in the frame of the piano's centre of mass: the grasp of user A (0) or B (1).
pbd::Vec3 piano_handle(std::size_t user);

/// The path through the maze: moves with a rest at each end.
class PianoPath {
 public:
  PianoPath();
  double duration() const { return times_.back(); }  ///< s
  PianoPose at(double time) const;
  /// m, target of a user's handle, at height `z`.
  pbd::Vec3 handle(std::size_t user, double time, double z) const;
  PianoPose goal() const { return poses_.back(); }
  /// m along the path to the goal, from its point nearest to `position`; only x and y count.
  double left_from(const pbd::Vec3& position) const;
  double length() const { return left_from({poses_[0].x, poses_[0].y, 0.0}); }  ///< m

 private:
  std::vector<PianoPose> poses_;
  std::vector<double> times_;  ///< s, of the poses
};

}  // namespace tandem::demos
