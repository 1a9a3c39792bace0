// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "plaza/walker.h"

#include <algorithm>
#include <cmath>

#include "scenes/hand.h"

namespace tandem::demos {

namespace {

constexpr double kSpeed = 1.2;        // m/s
constexpr double kLift = 0.8;         // s
constexpr double kCarryHeight = 0.8;  // m
constexpr double kThrowAfter = 1.0;   // s: the body is up, and the arm begins to swing
constexpr double kSwing = 0.35;       // s
constexpr double kThrowSpeed = 4.0;   // m/s

}  // namespace

Walker::Walker(const PlazaOptions& options, std::size_t number)
    : options_(options),
      random_(derived_seed(options.seed, 3'000'000 + number)),
      feet_(start_of_person(options, number)),
      goal_(feet_) {
  begin_stroll();
  until_ *= random_.unit();
}

void Walker::begin_stroll() {
  act_ = Act::Stroll;
  time_ = 0.0;
  until_ = random_.uniform(1.5, 4.0);
  const double turn = random_.uniform(-3.14159, 3.14159);
  const double way = random_.uniform(3.0, 15.0);
  goal_ = feet_ + way * pbd::Vec3(std::cos(turn), std::sin(turn), 0.0);
  for (int i = 0; i < 2; ++i)
    goal_[i] = std::clamp(goal_[i], 0.5, std::max(0.6, options_.side - 0.5));
}

void Walker::walk(double dt) {
  const pbd::Vec3 left = goal_ - feet_;
  const double way = left.norm();
  if (way < 1e-6) return;
  ahead_ = left / way;
  feet_ += std::min(way, kSpeed * dt) * ahead_;
}

HandWish Walker::step(double dt) {
  time_ += dt;
  if (act_ == Act::Stroll) {
    walk(dt);
    if (time_ < until_) return {};
    return {HandWish::Kind::Look, feet_};
  }
  if (act_ != Act::Throw && time_ > kLift) walk(dt);
  if (time_ < until_) return {HandWish::Kind::Hold, hand_at(time_)};
  begin_stroll();
  return {HandWish::Kind::LetGo, feet_};
}

void Walker::take(const pbd::Vec3& body) {
  ++taken_;
  const double what = random_.unit();
  act_ = what < 0.5 ? Act::Carry : what < 0.75 ? Act::Push : Act::Throw;
  time_ = 0.0;
  until_ = act_ == Act::Throw ? kThrowAfter + kSwing : random_.uniform(3.0, 6.0);
  taken_at_ = body;
  offset_ = body - feet_;
  if (act_ == Act::Throw) {
    const double turn = random_.uniform(-3.14159, 3.14159);
    ahead_ = {std::cos(turn), std::sin(turn), 0.0};
  }
}

void Walker::lose() { begin_stroll(); }

pbd::Vec3 Walker::hand_at(double time) const {
  pbd::Vec3 hand = feet_ + offset_;
  hand.z() = taken_at_.z();
  if (act_ == Act::Push) return hand;
  hand.z() += kCarryHeight * min_jerk(time / kLift);
  if (act_ == Act::Carry) {
    // Lowered before release.
    hand.z() -= kCarryHeight * min_jerk((time - until_ + kLift) / kLift);
    return hand;
  }
  const double swing = std::max(0.0, time - kThrowAfter);
  return hand + (0.5 * kThrowSpeed / kSwing) * swing * swing * (ahead_ + 0.7 * pbd::Vec3::UnitZ());
}

}  // namespace tandem::demos
