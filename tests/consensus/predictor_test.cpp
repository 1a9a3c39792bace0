// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/predictor.h"

#include <array>
#include <memory>

#include "consensus/known_motion.h"
#include "consensus/random.h"
#include "support/catch.h"
#include "support/oracles.h"

namespace tandem::consensus::predictor_test {
namespace {

using pbd::Pose;
using pbd::Quat;
using pbd::TargetMotion;
using pbd::Twist;
using pbd::Vec3;
using tandem::testing::turn;
using testing::Dice;
using testing::KnownMotion;

constexpr SessionTime kNow = 5'000'000'000;
const Vec3 kGravity{0.0, 0.0, -9.81};
constexpr std::array kKinds{PredictorKind::None, PredictorKind::Euler, PredictorKind::Replay};

void check_close(const Vec3& value, const Vec3& wanted, double tolerance = 1e-12) {
  INFO("got " << value.transpose() << ", want " << wanted.transpose());
  CHECK((value - wanted).norm() <= tolerance);
}

KnownMotion standing(const Pose& pose, const Twist& twist, SessionTime now = kNow) {
  return KnownMotion(now, [=](SessionTime time) { return MotionSample{time, pose, twist}; });
}

StateUpdate some_state(Dice& dice) {
  StateUpdate update;
  update.id = {1, 1};
  update.pose = {dice.vec3(5.0), dice.rotation(3.0)};
  update.twist = {dice.vec3(3.0), dice.vec3(3.0)};
  return update;
}

TEST_CASE("predictor: Euler carries a state by age times velocity, Eq. 3", "[consensus]") {
  const auto euler = make_predictor(PredictorKind::Euler);
  Dice dice(1);
  for (int i = 0; i < 50; ++i) {
    const Pose own{dice.vec3(5.0), dice.rotation(3.0)};
    const Twist own_twist{dice.vec3(3.0), dice.vec3(3.0)};
    StateUpdate update = some_state(dice);
    const auto late = static_cast<SessionTime>(dice.below(200'000'000));
    update.stamp = kNow - late;
    const double age = 1e-9 * static_cast<double>(late);

    const Prediction p = euler->predict(update, standing(own, own_twist), {.now = kNow});
    check_close(own.position + p.translation, update.pose.position + age * update.twist.linear);
    const Quat wanted = turn(age * update.twist.angular) * update.pose.orientation;
    CHECK(tandem::testing::angle_between(turn(p.rotation) * own.orientation, wanted) < 1e-12);
    check_close(own_twist.linear + p.twist.linear, update.twist.linear);
    check_close(own_twist.angular + p.twist.angular, update.twist.angular);
    CHECK(p.motion == TargetMotion::WithBody);
  }
}

TEST_CASE("predictor: without extrapolation of orientations they stay as stamped, Sec. 4.2",
          "[consensus][unit]") {
  const auto euler = make_predictor(PredictorKind::Euler, {.extrapolates_orientation = false});
  Dice dice(2);
  StateUpdate update = some_state(dice);
  update.stamp = kNow - 100'000'000;
  const Prediction p = euler->predict(update, KnownMotion(kNow), {.now = kNow});
  CHECK(tandem::testing::angle_between(turn(p.rotation), update.pose.orientation) < 1e-12);
  check_close(p.translation, update.pose.position + 0.1 * update.twist.linear);
}

TEST_CASE("predictor: a body moved by a hand goes straight on", "[consensus]") {
  // Its own velocity is the hand's: gravity does not act on it, nor does what the body here does.
  // (From several states of an owner's hand it is measured what its velocity changes by.)
  Dice dice(3);
  StateUpdate update = some_state(dice);
  update.stamp = kNow - 160'000'000;
  update.flags.owner_driven = true;
  const Pose own{dice.vec3(1.0), dice.rotation(1.0)};
  const Twist own_twist{Vec3(0.0, 0.7, 0.0), Vec3::Zero()};
  for (const PredictorKind kind : {PredictorKind::Euler, PredictorKind::Replay}) {
    PredictorMemory memory;
    const Prediction p = make_predictor(kind)->predict(
        update, standing(own, own_twist), {.now = kNow, .gravity = kGravity, .memory = &memory});
    check_close(own.position + p.translation, update.pose.position + 0.16 * update.twist.linear);
    check_close(own_twist.linear + p.twist.linear, update.twist.linear);
    CHECK(p.motion == TargetMotion::Inertial);
  }
}

TEST_CASE("predictor: bodies neither replayed nor owned are carried by Euler",
          "[consensus][unit]") {
  const auto replay = make_predictor(PredictorKind::Replay);
  const auto euler = make_predictor(PredictorKind::Euler);
  CHECK(replay->remembers());
  Dice dice(4);
  PredictorMemory a;
  for (int i = 0; i < 20; ++i) {
    StateUpdate update = some_state(dice);
    update.stamp = kNow + i * 16'000'000;
    update.influence = 0.5F;
    update.flags.in_contact = i % 3 == 0;
    const SessionTime now = update.stamp + 50'000'000;
    const KnownMotion own(now);
    const Prediction p = replay->predict(update, own, {now, kGravity, &a});
    const Prediction q = euler->predict(update, own, {now, kGravity});
    CHECK(p.translation == q.translation);
    CHECK(p.rotation == q.rotation);
    CHECK(p.twist.linear == q.twist.linear);
  }
}

TEST_CASE("predictor: the epoch does not matter", "[consensus]") {
  // 1.7e18 ns is today in Unix time; doubles are 256 ns apart there.
  for (const PredictorKind kind : kKinds) {
    const auto predict = [&](SessionTime origin) {
      Dice dice(5);
      StateUpdate update = some_state(dice);
      update.stamp = origin + 1'234'567;
      PredictorMemory memory;
      const SessionTime now = origin + 160'000'000;
      return make_predictor(kind)->predict(update, KnownMotion(now), {now, kGravity, &memory});
    };
    const Prediction a = predict(1);
    const Prediction b = predict(1'700'000'000'123'456'789);
    check_close(a.translation, b.translation, 1e-8);  // 1 ns, which is also 0 here
    check_close(a.rotation, b.rotation, 1e-8);
    check_close(a.twist.linear, b.twist.linear, 1e-7);
  }
}

}  // namespace
}  // namespace tandem::consensus::predictor_test
