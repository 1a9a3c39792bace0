// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/tennis_player.h"

#include <algorithm>
#include <cmath>

namespace tandem::demos {

namespace {

using pbd::Vec3;

constexpr double kGravity = 9.81;
constexpr double kFastest = 2.0;  // m/s, mean speed of a racket's move
constexpr double kLow = 0.05;     // m below the table, where a ball is lost

std::vector<std::size_t> all_balls(const Scene& scene) {
  std::vector<std::size_t> balls;
  for (int k = 0; k < TennisScenario::kBalls; ++k) {
    balls.push_back(scene.index_of("ball/" + std::to_string(k)));
  }
  return balls;
}

}  // namespace

Vec3 tennis_home(const TennisCourt& court, std::size_t user) {
  return {tennis_side(user) * (court.half_length + 0.2), 0.0, court.height + 0.4};
}

void BallFlight::advance(const TennisCourt& court, double dt) {
  position += dt * velocity;
  position.z() -= 0.5 * kGravity * dt * dt;
  velocity.z() -= kGravity * dt;
  const double surface = court.height + court.ball_radius;
  const bool above = std::abs(position.x()) < court.half_length &&
                     std::abs(position.y()) < court.half_width &&
                     position.z() > court.height - 0.05;
  if (above && position.z() < surface && velocity.z() < 0.0) {
    position.z() = 2.0 * surface - position.z();
    velocity.z() *= -court.table_bounce;
    ++bounces;
  }
}

Stroke stroke_to(const TennisCourt& court, const BallFlight& ball, const Vec3& target,
                 double seconds) {
  Vec3 leaving = (target - ball.position) / seconds;
  leaving.z() += 0.5 * kGravity * seconds;
  const Vec3 change = leaving - ball.velocity;
  Stroke stroke;
  stroke.ball = ball.position;
  stroke.normal = change.normalized();
  // A heavy blade at speed u gives n.(v' - v) = (1 + e) (u - n.v).
  stroke.speed = change.norm() / (1.0 + court.blade_bounce) + stroke.normal.dot(ball.velocity);
  return stroke;
}

TennisPlayer::TennisPlayer(std::size_t user, const TennisCourt& court, Controls& controls,
                           const UserOptions& options)
    : user_(user),
      side_(tennis_side(user)),
      court_(court),
      controls_(controls),
      racket_(controls.scene().index_of("racket/" + std::to_string(user))),
      sight_(controls.scene(), all_balls(controls.scene()), options.reaction),
      random_(derived_seed(options.seed, 19)),
      tremor_(options.seed, options.tremor),
      next_serve_(1.0 + random_.uniform(-0.1, 0.1)),
      move_(tennis_home(court, user)),
      from_(pbd::Quat::Identity()),
      to_(pbd::Quat::Identity()) {
  draw_target();
}

void TennisPlayer::draw_target() {
  // Towards the partner, to keep the rally going.
  target_ = Vec3(-side_ * random_.uniform(0.65, 0.95), random_.uniform(-0.1, 0.1),
                 court_.height + court_.ball_radius);
  flight_ = random_.uniform(0.55, 0.65);
  const auto error = [this](double most) { return random_.uniform(-most, most); };
  aim_error_ = Vec3(error(0.01), error(0.01), error(0.01));
}

pbd::Quat TennisPlayer::blade(const Vec3& normal) const {
  return pbd::Quat::FromTwoVectors(Vec3::UnitX(), -side_ * normal);
}

void TennisPlayer::update(consensus::SessionTime /*now*/) {
  const double time = controls_.time();
  sight_.look(time);
  serve(time);
  plan(time);
  const double end = time + controls_.dt();
  pbd::Pose pose;
  pose.position = move_.at(end).position + tremor_.at(end);
  const double part =
      move_.end() > move_.start() ? (end - move_.start()) / (move_.end() - move_.start()) : 1.0;
  pose.orientation = from_.slerp(min_jerk(part), to_);
  controls_.drive(racket_, pose);
}

std::optional<std::size_t> TennisPlayer::ball_in_play() const {
  for (std::size_t k = TennisScenario::kBalls; k-- > 0;) {
    const SceneBody& body = controls_.scene().body("ball/" + std::to_string(k));
    const Vec3& p = sight_.seen(k).pose.position;
    const bool waits = (p - body.start).norm() < 0.01;
    const bool over = p.z() < court_.height - 0.1 || std::abs(p.x()) > court_.half_length + 1.0;
    if (!waits && !over) return k;
  }
  return std::nullopt;
}

void TennisPlayer::serve(double time) {
  // A ball that rests on the table, or that the peers cannot agree on, is out of play too.
  const std::optional<std::size_t> ball = ball_in_play();
  if (ball && sight_.seen(*ball).twist.linear.norm() > 0.2) quiet_since_ = time;
  if (time < next_serve_ || time < quiet_since_ + 0.5) return;
  for (int k = 0; k < TennisScenario::kBalls; ++k) {
    const SceneBody& body = controls_.scene().body("ball/" + std::to_string(k));
    const auto number = static_cast<std::size_t>(k);
    if ((sight_.seen(number).pose.position - body.start).norm() >= 0.01) continue;
    if (number % 2 != user_) return;  // the other's turn
    controls_.signal(static_cast<std::uint32_t>(k) + 1, TennisScenario::kServeLead);
    next_serve_ = time + 1.5;
    return;
  }
}

void TennisPlayer::plan(double time) {
  if (stroke_ && time > stroke_->time + 0.05) {
    strokes_ += 1.0;
    blind_until_ = stroke_->time + 0.03;
    stroke_.reset();
    draw_target();
    go_home(time);
  }
  if (stroke_ && time > stroke_->time - kCommit) return;
  if (sight_.seen_at() < blind_until_) return;
  const std::optional<std::size_t> ball = ball_in_play();
  const std::optional<Stroke> stroke = ball ? find_stroke(*ball, time) : std::nullopt;
  if (stroke) {
    swing(*stroke, time);
  } else if (stroke_) {
    stroke_.reset();
    go_home(time);
  }
}

std::optional<Stroke> TennisPlayer::find_stroke(std::size_t ball, double time) {
  const pbd::BodyState& seen = sight_.seen(ball);
  BallFlight flight{seen.pose.position, seen.twist.linear, 0};
  // The own serve: the ball falls and bounces beside this player.
  const bool own_serve = std::abs(flight.velocity.x()) < 0.5 && flight.position.x() * side_ > 0.9;
  if (!own_serve && flight.velocity.x() * side_ < 0.5) return std::nullopt;
  // A rising ball that fell from rest has already bounced.
  if (own_serve && flight.velocity.z() > 0.0) flight.bounces = 1;
  constexpr double kDt = 0.004;
  const double plane = court_.half_length + 0.12;
  const Vec3 racket = move_.at(time).position;
  for (double t = sight_.seen_at(); t < time + 1.5; t += kDt) {
    const double before = flight.position.x();
    flight.advance(court_, kDt);
    const bool into_net = before * flight.position.x() <= 0.0 && !own_serve &&
                          flight.position.z() < court_.height + court_.net + court_.ball_radius;
    if (into_net || flight.position.z() < court_.height - kLow) return std::nullopt;
    const bool falls_back = flight.bounces > 0 && flight.velocity.z() < 0.0 &&
                            flight.position.z() < court_.height + 0.4;
    const bool ready = own_serve ? falls_back : flight.position.x() * side_ > plane;
    // A player who sees it late takes the ball later, farther back.
    const double left = t + kDt - time;
    if (!ready || left < 0.06 || (flight.position - racket).norm() > kFastest * left) continue;
    Stroke stroke = stroke_to(court_, flight, target_, flight_);
    stroke.time = t + kDt;
    return stroke;
  }
  return std::nullopt;
}

void TennisPlayer::swing(const Stroke& stroke, double time) {
  const MinJerkMove::State now = move_.at(time);
  const Vec3 normal = (stroke.normal + aim_error_).normalized();
  MinJerkMove::State meet;
  meet.position = stroke.ball - (court_.ball_radius + court_.blade_thick) * normal;
  meet.velocity = stroke.speed * normal;
  if (stroke_ && std::abs(stroke_->time - stroke.time) < 0.004 &&
      (stroke_->ball - stroke.ball).norm() < 0.005) {
    return;  // keeps the plan
  }
  const double part =
      move_.end() > move_.start() ? (time - move_.start()) / (move_.end() - move_.start()) : 1.0;
  from_ = from_.slerp(min_jerk(part), to_);
  to_ = blade(normal);
  move_ = MinJerkMove(time, now, stroke.time, meet);
  stroke_ = stroke;
}

void TennisPlayer::go_home(double time) {
  const double part =
      move_.end() > move_.start() ? (time - move_.start()) / (move_.end() - move_.start()) : 1.0;
  from_ = from_.slerp(min_jerk(part), to_);
  to_ = pbd::Quat::Identity();
  MinJerkMove::State home;
  home.position = tennis_home(court_, user_);
  move_ = MinJerkMove(time, move_.at(time), time + 0.5, home);
}

}  // namespace tandem::demos
