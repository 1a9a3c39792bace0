// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/tennis.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/tennis_player.h"
#include "scenes/words.h"

namespace tandem::demos {

namespace {

using pbd::Vec3;

constexpr std::uint32_t kBallBit = 2;
constexpr std::uint32_t kRacketBit = 4;

collision::Material bouncing(double restitution) {
  collision::Material material;
  material.friction = 0.0;  // the players calculate without spin
  material.restitution = restitution;
  material.friction_rule = collision::Combine::Minimum;
  return material;
}

BodySpec racket(const TennisCourt& court, std::size_t user) {
  BodySpec spec;
  spec.name = "racket/" + std::to_string(user);
  spec.parts =
      one_part(collision::Box{Vec3(court.blade_thick, court.blade_half, court.blade_half)});
  spec.pose.position = tennis_home(court, user);
  spec.mass = 5.0;  // heavy enough to follow the hand against a ball
  spec.material = bouncing(court.blade_bounce);
  spec.filter.category = kRacketBit;
  spec.filter.mask = kBallBit;
  spec.owner = user;
  return spec;
}

BodySpec ball(const TennisCourt& court, int number) {
  BodySpec spec;
  spec.name = "ball/" + std::to_string(number);
  spec.parts = one_part(collision::Sphere{court.ball_radius});
  spec.mass = court.ball_mass;
  const double side = tennis_side(static_cast<std::size_t>(number % 2));
  const double y = 0.1 * (number / 2 - 0.5 * (TennisScenario::kBalls / 2 - 1));
  spec.pose = upright_at(side * court.serve_x, y, court.hold_height);
  spec.material = bouncing(0.0);
  spec.filter.category = kBallBit;
  spec.bullet = true;
  spec.held_up = true;
  return spec;
}

/// Counts hits, rallies and balls that passed through a blade.
class TennisReferee final : public Referee {
 public:
  TennisReferee(const TennisCourt& court, const Scene& scene) : court_(court) {
    for (std::size_t user = 0; user < 2; ++user) {
      rackets_[user] = scene.index_of("racket/" + std::to_string(user));
    }
    for (int k = 0; k < TennisScenario::kBalls; ++k) {
      balls_.push_back({.body = scene.index_of("ball/" + std::to_string(k))});
    }
  }

  void watch(const Scene& scene, double /*time*/) override {
    for (Ball& ball : balls_) {
      const pbd::BodyState& state = scene.world->state(scene.bodies[ball.body].body);
      if (scene.world->props(scene.bodies[ball.body].body).gravity_scale == 0.0) continue;
      const Vec3 before = ball.seen ? ball.velocity : state.twist.linear;
      if (!ball.seen) served_ += 1.0;
      for (std::size_t user = 0; user < 2; ++user) {
        const double side = tennis_side(user);
        const pbd::Pose& blade = scene.pose(rackets_[user]);
        const Vec3 local = blade.to_local(state.pose.position);
        const bool turned = before.x() * side > -0.3 && state.twist.linear.x() * side < -0.5;
        const bool hit = turned && local.norm() < 0.35;
        if (hit) {
          hits_ += 1.0;
          ball.rally += 1.0;
          longest_ = std::max(longest_, ball.rally);
        }
        if (ball.seen && !hit && got_through(ball.local[user], local)) {
          through_ += 1.0;
          const pbd::BodyId blade_id = scene.bodies[rackets_[user]].body;
          const bool own = scene.world->props(blade_id).type == pbd::BodyType::Kinematic;
          if (own) through_own_ += 1.0;
        }
        ball.local[user] = local;
      }
      ball.seen = true;
      ball.velocity = state.twist.linear;
      // The rally ends below the table.
      if (state.pose.position.z() < court_.height - 0.1) ball.rally = 0.0;
    }
  }

  Outcome outcome(const Scene& /*scene*/) const override {
    return {{"served", served_},
            {"hits", hits_},
            {"longest_rally", longest_},
            {"tunnelled", through_},
            {"tunnelled_own", through_own_}};
  }

 private:
  struct Ball {
    std::size_t body = 0;
    bool seen = false;  ///< was in play before
    Vec3 velocity = Vec3::Zero();
    std::array<Vec3, 2> local{Vec3::Zero(),
                              Vec3::Zero()};  ///< m, in the frame of each blade, at the last step
    double rally = 0.0;                       ///< hits
  };

  /// From one side of the blade to the other, through its middle.
  bool got_through(const Vec3& from, const Vec3& to) const {
    if (from.x() * to.x() >= 0.0) return false;
    const double s = from.x() / (from.x() - to.x());
    const Vec3 there = from + s * (to - from);
    const double reach = court_.blade_half - court_.ball_radius;
    return std::abs(there.y()) < reach && std::abs(there.z()) < reach;
  }

  TennisCourt court_;
  std::array<std::size_t, 2> rackets_{};
  std::vector<Ball> balls_;
  double served_ = 0.0, hits_ = 0.0, longest_ = 0.0, through_ = 0.0;
  double through_own_ = 0.0;  ///< through the racket of a local user
};

}  // namespace

Scene TennisScenario::build(const SceneOptions& options) const {
  const TennisCourt& c = court_;
  SceneBuilder builder;
  builder.add(racket(c, 0));
  builder.add(racket(c, 1));
  for (int k = 0; k < kBalls; ++k) builder.add(ball(c, k));
  constexpr double kTop = 0.03;  // half the thickness of the top
  builder.fix(collision::Box{Vec3(c.half_length, c.half_width, kTop)},
              upright_at(0, 0, c.height - kTop), bouncing(c.table_bounce));
  builder.fix(collision::Box{Vec3(0.005, c.half_width + 0.15, 0.5 * c.net)},
              upright_at(0, 0, c.height + 0.5 * c.net), bouncing(0.1));
  builder.ground(bouncing(0.5));
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
    builder.half_space(normal, -4.0, bouncing(0.3));
  }
  return builder.build(options);
}

std::unique_ptr<User> TennisScenario::make_user(std::size_t user, Controls& controls,
                                                const UserOptions& options) const {
  require_user(user);
  return std::make_unique<TennisPlayer>(user, court_, controls, options);
}

void TennisScenario::on_signal(Scene& scene, const Signal& signal,
                               consensus::SessionTime now) const {
  if (signal.code < 1 || signal.code > static_cast<std::uint32_t>(kBalls)) return;
  const double age = 1e-9 * static_cast<double>(now - signal.time);
  constexpr double kMaxAge = 0.3;  // s: later it would be under the table
  let_fall(scene, scene.index_of("ball/" + std::to_string(signal.code - 1)),
           std::min(age, kMaxAge));
}

std::unique_ptr<Referee> TennisScenario::make_referee(const Scene& scene) const {
  return std::make_unique<TennisReferee>(court_, scene);
}

Achievement TennisScenario::achievement(const Outcome& outcome) const {
  const auto balls = static_cast<std::size_t>(value_of(outcome, "served"));
  const auto longest = static_cast<std::size_t>(value_of(outcome, "longest_rally"));
  return {"played table tennis with " + count_words(balls, "ball") + ", " +
              count_words(longest, "stroke") + " in a row at most",
          "strokes in a row", std::to_string(longest), balls <= 1 && longest > 1};
}

}  // namespace tandem::demos
