// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "scenes/random.h"
#include "scenes/tennis.h"

namespace tandem::demos {

/// m, rest position of a player's racket, near most strokes.
pbd::Vec3 tennis_home(const TennisCourt& court, std::size_t user);

struct BallFlight {
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m
  pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s
  int bounces = 0;                         ///< on the table, so far
  /// Advances by `dt` (s): gravity, and bounces off the table.
  void advance(const TennisCourt& court, double dt);
};

/// Time, place and speed of the blade when it meets a ball.
struct Stroke {
  double time = 0.0;                      ///< s since the epoch
  pbd::Vec3 ball = pbd::Vec3::Zero();     ///< m, where they meet
  pbd::Vec3 normal = pbd::Vec3::UnitX();  ///< unit, towards the target
  double speed = 0.0;                     ///< m/s, of the blade along the normal
};

/// The stroke that sends a ball, met at its present position, to `target` within `seconds`.
Stroke stroke_to(const TennisCourt& court, const BallFlight& ball, const pbd::Vec3& target,
                 double seconds);

/// Plays table tennis in its own peer's world. It sees the ball a reaction time late, predicts its
/// flight, and meets it with the racket on a minimum-jerk path.
class TennisPlayer final : public User {
 public:
  TennisPlayer(std::size_t user, const TennisCourt& court, Controls& controls,
               const UserOptions& options);
  void update(consensus::SessionTime now) override;
  Outcome outcome() const override { return {{"strokes", strokes_}}; }

 private:
  static constexpr double kCommit = 0.1;  ///< s before the stroke: no more changes

  void serve(double time);
  void plan(double time);
  /// The flying ball, as seen; none if all rest or wait.
  std::optional<std::size_t> ball_in_play() const;
  std::optional<Stroke> find_stroke(std::size_t ball, double time);
  void swing(const Stroke& stroke, double time);
  void go_home(double time);
  void draw_target();
  pbd::Quat blade(const pbd::Vec3& normal) const;

  std::size_t user_;
  double side_;
  TennisCourt court_;
  Controls& controls_;
  std::size_t racket_;
  Sight sight_;
  Random random_;
  Tremor tremor_;
  double next_serve_;         ///< s, earliest time
  double quiet_since_ = 0.0;  ///< s, without a flying ball
  MinJerkMove move_;          ///< of the racket's middle
  pbd::Quat from_, to_;       ///< orientation at both ends of the move
  std::optional<Stroke> stroke_;
  double blind_until_ = 0.0;  ///< s: until then the seen ball is from before the stroke
  pbd::Vec3 target_ = pbd::Vec3::Zero();
  pbd::Vec3 aim_error_ = pbd::Vec3::Zero();
  double flight_ = 0.5;  ///< s, from the stroke to the target
  double strokes_ = 0.0;
};

}  // namespace tandem::demos
