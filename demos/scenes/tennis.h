// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/scenario.h"

namespace tandem::demos {

/// Dimensions of a table tennis game. The table is along x, centred above the origin.
struct TennisCourt {
  double half_length = 1.37;   ///< m, of the table, along x
  double half_width = 0.7625;  ///< m, along y
  double height = 0.76;        ///< m, of its surface
  double net = 0.1525;         ///< m, above the surface
  double ball_radius = 0.02;   ///< m
  double ball_mass = 0.0027;   ///< kg
  double blade_half = 0.08;    ///< m
  double blade_thick = 0.01;   ///< m, half thickness
  double table_bounce = 0.88;  ///< restitution
  double blade_bounce = 0.75;
  double hold_height = 1.5;  ///< m, where waiting balls are held
  double serve_x = 1.25;     ///< m, on the server's side
};

/// Two users play table tennis, after [friston] Sec. 5.3. Each owns a racket; the balls are shared.
/// User A (0) plays at -x. Balls wait in the air; user k % 2 drops ball k by a signal and serves it
/// after its bounce. Names: "racket/<user>", "ball/<number>".
class TennisScenario final : public Scenario {
 public:
  static constexpr int kBalls = 12;
  static constexpr double kServeLead = 0.2;  ///< s, from the signal to the fall

  const TennisCourt& court() const { return court_; }
  TennisScenario() : Scenario("tennis", 2) {}

  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  /// Code k + 1 drops ball k.
  void on_signal(Scene& scene, const Signal& signal, consensus::SessionTime now) const override;
  Bounds bounds() const override { return {.max_distance = 8.0, .max_speed = 40.0, .lowest = 0.0}; }
  std::unique_ptr<Referee> make_referee(const Scene& scene) const override;
  Achievement achievement(const Outcome& outcome) const override;
  std::string_view baseline() const override { return "single-owner"; }

 private:
  TennisCourt court_;
};

/// -1 or +1.
inline double tennis_side(std::size_t user) { return user == 0 ? -1.0 : 1.0; }

}  // namespace tandem::demos
