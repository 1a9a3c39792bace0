// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/predictor.h"

#include <cmath>
#include <functional>
#include <vector>

#include "consensus/random.h"
#include "support/catch.h"
#include "support/oracles.h"

namespace tandem::consensus::predictor_test {
namespace {

using pbd::Correction;
using pbd::Pose;
using pbd::Quat;
using pbd::TargetMotion;
using pbd::Twist;
using pbd::Vec3;
using tandem::testing::turn;
using testing::Dice;

constexpr SessionTime kStep = 16'000'000;  // ns
constexpr double kDt = 0.016;              // s
constexpr SessionTime kOrigin = 5'000'000'000;

/// What a body did: a state and what agreement added, at each step.
struct Motion {
  std::function<Pose(double)> pose = [](double) { return Pose{}; };
  std::function<Twist(double)> twist = [](double) { return Twist{}; };
  std::function<Correction(int)> correction = [](int) { return Correction{}; };
  std::function<bool(int)> coupled = [](int) { return false; };

  /// `count` samples from `origin` on; t = 0 there.
  MotionHistory history(int count, SessionTime origin = kOrigin) const {
    MotionHistory history;
    for (int i = 0; i < count; ++i) {
      history.push(origin + i * kStep, pose(i * kDt), twist(i * kDt), correction(i), coupled(i));
    }
    return history;
  }
};

const Vec3 kGravity{0.0, 0.0, -9.81};

Motion projectile(const Vec3& x, const Vec3& v) {
  return {.pose =
              [=](double t) {
                return Pose{x + t * v + 0.5 * t * t * kGravity, Quat::Identity()};
              },
          .twist =
              [=](double t) {
                return Twist{v + t * kGravity, Vec3::Zero()};
              }};
}

/// The remote's update: `own` at the step `index`, moved by an offset.
StateUpdate update_at(const Motion& own, int index, const Vec3& offset,
                      const Vec3& dv = Vec3::Zero(), SessionTime origin = kOrigin) {
  StateUpdate update;
  update.id = {1, 1};
  update.pose = own.pose(index * kDt);
  update.pose.position += offset;
  update.twist = own.twist(index * kDt);
  update.twist.linear += dv;
  update.stamp = origin + index * kStep;
  return update;
}

PredictionContext at_step(int index, double mirrored = 1.0, int peers = 1) {
  return {.now = kOrigin + index * kStep, .mirrored_share = mirrored, .peers = peers};
}

void check_close(const Vec3& value, const Vec3& wanted, double tolerance = 1e-12) {
  INFO("got " << value.transpose() << ", want " << wanted.transpose());
  CHECK((value - wanted).norm() <= tolerance);
}

const std::unique_ptr<Predictor> kEuler = make_predictor(PredictorKind::Euler);
const std::unique_ptr<Predictor> kLocal = make_predictor(PredictorKind::Blend);

TEST_CASE("predictor: Euler carries a state by age times velocity, Eq. 3", "[consensus]") {
  Dice dice(1);
  for (int i = 0; i < 50; ++i) {
    const Pose own{dice.vec3(5.0), dice.rotation(3.0)};
    const Twist own_twist{dice.vec3(3.0), dice.vec3(3.0)};
    MotionHistory history;
    history.push(kOrigin, own, own_twist, {}, false);
    StateUpdate update;
    update.pose = {dice.vec3(5.0), dice.rotation(3.0)};
    update.twist = {dice.vec3(3.0), dice.vec3(3.0)};
    const auto late = static_cast<SessionTime>(dice.below(200'000'000));
    update.stamp = kOrigin - late;
    const double age = 1e-9 * static_cast<double>(late);

    const Prediction p = kEuler->predict(update, history, at_step(0));
    check_close(own.position + p.translation, update.pose.position + age * update.twist.linear);
    const Quat wanted = turn(age * update.twist.angular) * update.pose.orientation;
    CHECK(tandem::testing::angle_between(turn(p.rotation) * own.orientation, wanted) < 1e-12);
    check_close(own_twist.linear + p.twist.linear, update.twist.linear);
    check_close(own_twist.angular + p.twist.angular, update.twist.angular);
    CHECK(p.motion == TargetMotion::WithBody);
  }
}

TEST_CASE("predictor: local motion returns the offset of a falling body exactly", "[consensus]") {
  const Motion own = projectile({1.0, 2.0, 3.0}, {4.0, -1.0, 6.0});
  const MotionHistory history = own.history(40);
  const Vec3 offset(0.03, -0.02, 0.05);
  for (int stamp = 20; stamp < 40; ++stamp) {
    const Prediction p = kLocal->predict(update_at(own, stamp, offset), history, at_step(39));
    check_close(p.translation, offset);
    check_close(p.rotation, Vec3::Zero());
    check_close(p.twist.linear, Vec3::Zero());
    CHECK(p.motion == TargetMotion::WithBody);
  }
}

TEST_CASE("predictor: histories side by side in one memory are as those alone", "[consensus]") {
  const Motion first = projectile({1.0, 2.0, 3.0}, {4.0, -1.0, 6.0});
  const Motion second = projectile({-5.0, 0.5, 1.0}, {-2.0, 3.0, 1.0});
  constexpr int kCount = static_cast<int>(MotionHistory::kCapacity) + 30;  // round the ring
  std::vector<MotionSample> memory(2 * MotionHistory::kCapacity);
  MotionHistory a(memory, 0, 2);
  MotionHistory b(memory, 1, 2);
  for (int i = 0; i < kCount; ++i) {
    const double t = i * kDt;
    a.push(kOrigin + i * kStep, first.pose(t), first.twist(t), {}, false);
    b.push(kOrigin + i * kStep, second.pose(t), second.twist(t), {}, false);
  }
  const MotionHistory alone_a = first.history(kCount);
  const MotionHistory alone_b = second.history(kCount);
  for (int late = 0; late < kCount; ++late) {
    const SessionTime time = kOrigin + (kCount - 1 - late) * kStep + kStep / 3;
    CHECK(a.at_time(time).pose.position == alone_a.at_time(time).pose.position);
    CHECK(b.at_time(time).pose.position == alone_b.at_time(time).pose.position);
  }
}

TEST_CASE("predictor: between two samples the own state is interpolated", "[consensus]") {
  const bool touches = GENERATE(false, true);
  Motion own = projectile(Vec3::Zero(), {4.0, -1.0, 6.0});
  own.coupled = [touches](int) { return touches; };
  const MotionHistory history = own.history(40);
  for (const double f : {0.1, 0.5, 0.9}) {
    const double t = (30.0 + f) * kDt;
    StateUpdate update = update_at(own, 0, Vec3::Zero());
    update.pose = own.pose(t);
    update.twist = own.twist(t);
    update.stamp = kOrigin + std::llround(1e9 * t);
    // A chord lies below a parabola by g f (1 - f) dt^2 / 2; velocities are straight lines. What
    // flies is followed on the parabola itself.
    const Vec3 bow = touches ? Vec3(-0.5 * f * (1.0 - f) * kDt * kDt * kGravity) : Vec3::Zero();
    const Prediction p = kLocal->predict(update, history, at_step(39));
    check_close(p.translation, bow, 1e-9);
    check_close(p.twist.linear, Vec3::Zero(), 1e-9);
  }
}

TEST_CASE("predictor: own and mirrored corrections since the stamp are taken off", "[consensus]") {
  // Pulled by 1 mm in each step, 10 of them since the stamp.
  const Vec3 pull(1e-3, 0.0, -5e-4);
  const Vec3 twirl(0.0, 2e-3, 0.0);
  Motion own;
  own.correction = [=](int) { return Correction{.translation = pull, .rotation = twirl}; };
  own.coupled = [](int) { return true; };
  const MotionHistory history = own.history(40);
  const Vec3 offset(0.05, 0.0, 0.0);
  const StateUpdate update = update_at(own, 29, offset);
  for (const double r : {0.0, 0.5, 1.0, 2.0}) {
    const Prediction p = kLocal->predict(update, history, at_step(39, r));
    check_close(p.translation, offset - (1.0 + r) * 10.0 * pull);
    check_close(p.rotation, -(1.0 + r) * 10.0 * twirl);
  }
  // Of two others each moves towards me by its half only.
  const Prediction p = kLocal->predict(update, history, at_step(39, 1.0, 2));
  check_close(p.translation, offset - 1.5 * 10.0 * pull);
}

TEST_CASE("predictor: differences of velocity carry free bodies only", "[consensus]") {
  const Vec3 offset(0.02, 0.0, 0.0);
  const Vec3 dv(0.1, -0.2, 0.3);
  const double age = 10 * kDt;
  Motion own = projectile(Vec3::Zero(), {1.0, 0.0, 0.0});
  StateUpdate update = update_at(own, 29, offset, dv);
  update.twist.angular = Vec3(0.0, 0.5, 0.0);
  const auto expect = [&](const Vec3& translation, const Vec3& rotation) {
    const Prediction p = kLocal->predict(update, own.history(40), at_step(39));
    check_close(p.translation, translation);
    check_close(p.rotation, rotation);
    check_close(p.twist.linear, dv);
  };
  const Vec3 moved = offset + age * dv;
  const Vec3 turned = age * update.twist.angular;
  SECTION("free") { expect(moved, turned); }
  SECTION("the remote touches something") {
    update.flags.in_contact = true;
    expect(offset, Vec3::Zero());
  }
  SECTION("the remote is held") {
    update.flags.held = true;
    expect(offset, Vec3::Zero());
  }
  SECTION("this one touched something since the stamp") {
    own.coupled = [](int i) { return i == 33; };
    expect(offset, Vec3::Zero());
  }
  SECTION("this one touched something before the stamp only") {
    own.coupled = [](int i) { return i < 28; };
    expect(moved, turned);
  }
}

TEST_CASE("predictor: the way that velocity agreement added is taken off", "[consensus]") {
  const Vec3 dv(0.2, 0.0, -0.1);
  Motion own;
  own.correction = [](int i) {
    return Correction{.twist = {Vec3(0.001 * i, 0.0, 0.002), Vec3(0.0, 0.003, 0.0)}};
  };
  const StateUpdate update = update_at(own, 29, Vec3::Zero(), dv);
  Twist added;
  Twist way;
  for (int i = 30; i < 40; ++i) {
    const Correction c = own.correction(i);
    added.linear += c.twist.linear;
    added.angular += c.twist.angular;
    way.linear += (39 - i) * kDt * c.twist.linear;
    way.angular += (39 - i) * kDt * c.twist.angular;
  }
  for (const double r : {0.0, 1.0}) {
    const Prediction p = kLocal->predict(update, own.history(40), at_step(39, r));
    check_close(p.twist.linear, dv - (1.0 + r) * added.linear);
    check_close(p.twist.angular, -(1.0 + r) * added.angular);
    check_close(p.translation, 10 * kDt * dv - (1.0 + r) * way.linear);
    check_close(p.rotation, -(1.0 + r) * way.angular);
  }
}

TEST_CASE("predictor: what a hand moves is carried on straight, whatever happens here",
          "[consensus]") {
  Motion own = projectile(Vec3::Zero(), {1.0, 0.0, 0.0});
  own.correction = [](int) { return Correction{.translation = Vec3(0.01, 0.0, 0.0)}; };
  own.coupled = [](int i) { return i % 2 == 0; };
  StateUpdate update = update_at(own, 29, Vec3(0.04, 0.0, 0.0));
  update.twist.linear = Vec3(0.0, 0.7, 0.0);
  update.flags.owner_driven = true;
  const Prediction p = kLocal->predict(update, own.history(40), at_step(39));
  check_close(own.pose(39 * kDt).position + p.translation,
              update.pose.position + 10 * kDt * update.twist.linear);
  check_close(own.twist(39 * kDt).linear + p.twist.linear, update.twist.linear);
  CHECK(p.motion == TargetMotion::Inertial);
  CHECK(kEuler->predict(update, own.history(40), at_step(39)).motion == TargetMotion::Inertial);
}

TEST_CASE("predictor: own motion does not carry states far from here", "[consensus]") {
  // This body has moved by `way` since the stamp, the remote stood then; how much of it the remote
  // is carried by falls from all at 10 cm (20 degrees) to nothing at 30 cm (40 degrees).
  const Vec3 v(0.0, 0.3, 0.0);
  Motion own;
  own.pose = [=](double t) { return Pose{t * v, Quat::Identity()}; };
  own.twist = [=](double) { return Twist{v, Vec3::Zero()}; };
  own.coupled = [](int) { return true; };
  const MotionHistory history = own.history(40);
  const Vec3 way = 10 * kDt * v;
  const auto carried = [&](const Vec3& offset, const Vec3& rotation) {
    StateUpdate update = update_at(own, 29, offset, -v);
    update.pose.orientation = turn(rotation);
    const Prediction p = kLocal->predict(update, history, at_step(39));
    // Uncarried, the remote stays behind by the whole way.
    const Vec3 lag = offset - p.translation;
    CHECK(lag.cross(way).norm() < 1e-12);
    return 1.0 - lag.dot(way) / way.squaredNorm();
  };
  const Vec3 x = Vec3::UnitX();
  CHECK(carried(0.09 * x, Vec3::Zero()) == Approx(1.0).margin(1e-12));
  CHECK(carried(0.20 * x, Vec3::Zero()) == Approx(0.5).margin(1e-9));
  CHECK(carried(0.31 * x, Vec3::Zero()) == Approx(0.0).margin(1e-12));
  const double degree = tandem::testing::kPi / 180.0;
  CHECK(carried(Vec3::Zero(), 19.0 * degree * x) == Approx(1.0).margin(1e-12));
  CHECK(carried(Vec3::Zero(), 30.0 * degree * x) == Approx(0.5).margin(0.01));
  CHECK(carried(Vec3::Zero(), 41.0 * degree * x) == Approx(0.0).margin(1e-12));
  // The worse of the two counts.
  CHECK(carried(0.20 * x, 41.0 * degree * x) == Approx(0.0).margin(1e-12));
}

TEST_CASE("predictor: what is far from here goes its own way", "[consensus][analytic]") {
  // Half a metre apart; here it stands.
  const MotionHistory history = Motion{.coupled = [](int) { return true; }}.history(40);
  StateUpdate update = update_at({}, 29, Vec3(0.5, 0.0, 0.0), Vec3(0.0, 2.0, 0.0));
  PredictionContext context = at_step(39);
  context.gravity = kGravity;
  const double age = 10 * kDt;
  Prediction p = kLocal->predict(update, history, context);
  const Vec3 fall = 0.5 * age * age * kGravity;
  check_close(p.translation, Vec3(0.5, 2.0 * age, 0.0) + fall);
  check_close(p.twist.linear, Vec3(0.0, 2.0, 0.0) + age * kGravity);
  update.flags.in_contact = true;  // something carries it
  p = kLocal->predict(update, history, context);
  check_close(p.translation, Vec3(0.5, 2.0 * age, 0.0));
  check_close(p.twist.linear, Vec3(0.0, 2.0, 0.0));
}

TEST_CASE("predictor: what was let go there is not carried by the hand that holds it here",
          "[consensus][analytic]") {
  MotionHistory history;
  for (int i = 0; i < 40; ++i) {
    const bool held = i < 35;  // the news of the release came then
    history.push(kOrigin + i * kStep, {}, {}, {}, held, held);
  }
  StateUpdate update = update_at({}, 29, Vec3(0.02, 0.0, 0.0), Vec3(0.0, 0.4, 0.0));
  update.flags.leads = true;
  PredictionContext context = at_step(39);
  context.gravity = kGravity;
  const double age = 10 * kDt;
  check_close(kLocal->predict(update, history, context).translation,
              Vec3(0.02, 0.4 * age, 0.0) + 0.5 * age * age * kGravity);
  // Who does not lead may not know yet what the hand does: own motion tells.
  update.flags.leads = false;
  check_close(kLocal->predict(update, history, context).translation, Vec3(0.02, 0.0, 0.0));
  // Nobody has acted on it here since the stamp: velocities that differ carry it further.
  update.flags.leads = true;
  update.stamp = kOrigin + 36 * kStep;
  check_close(kLocal->predict(update, history, context).translation,
              Vec3(0.02, 0.4 * 3 * kDt, 0.0));
}

TEST_CASE("predictor: a stamp slightly ahead of now is no disagreement", "[consensus]") {
  const Vec3 v(2.0, 0.0, 1.0);
  const Vec3 spin(0.0, 0.0, 3.0);
  Motion own;
  own.pose = [=](double t) { return Pose{t * v, turn(t * spin)}; };
  own.twist = [=](double) { return Twist{v, spin}; };
  const double ahead = 0.005;
  StateUpdate update = update_at(own, 39, Vec3::Zero());
  update.stamp += 5'000'000;
  update.pose = own.pose(39 * kDt + ahead);
  update.pose.position.y() += 0.01;
  const Prediction p = kLocal->predict(update, own.history(40), at_step(39));
  check_close(p.translation, Vec3(0.0, 0.01, 0.0));
  check_close(p.twist.linear, Vec3::Zero());
  CHECK(p.rotation.norm() < 1e-12);
}

TEST_CASE("predictor: a rotational offset turns with the body", "[consensus]") {
  // Both spin about the world's z axis, the remote turned by 0.1 rad about x at the stamp: a
  // quarter turn later it is turned about y.
  const double age = 10 * kDt;
  const Vec3 spin(0.0, 0.0, 0.5 * tandem::testing::kPi / age);
  Motion own;
  own.pose = [=](double t) { return Pose{Vec3::Zero(), turn(t * spin)}; };
  own.twist = [=](double) { return Twist{Vec3::Zero(), spin}; };
  StateUpdate update = update_at(own, 29, Vec3::Zero());
  update.pose.orientation = turn(Vec3(0.1, 0.0, 0.0)) * update.pose.orientation;
  const Prediction p = kLocal->predict(update, own.history(40), at_step(39));
  check_close(p.rotation, Vec3(0.0, 0.1, 0.0));
}

TEST_CASE("predictor: the epoch does not matter", "[consensus]") {
  // 1.7e18 ns is today in Unix time; doubles are 256 ns apart there.
  Motion own = projectile({1.0, 2.0, 3.0}, {4.0, -1.0, 6.0});
  own.correction = [](int i) {
    return Correction{.translation = Vec3(1e-3, 0.0, 0.0),
                      .twist = {Vec3(0.001 * i, 0.0, 0.002), Vec3(0.0, 0.003, 0.0)}};
  };
  const auto predict = [&](const Predictor& predictor, SessionTime origin) {
    StateUpdate update = update_at(own, 29, Vec3(0.02, 0.0, 0.0), Vec3(0.1, 0.0, 0.0), origin);
    update.stamp += 1'234'567;
    return predictor.predict(update, own.history(40, origin), {.now = origin + 39 * kStep});
  };
  for (const Predictor* predictor : {kEuler.get(), kLocal.get()}) {
    const Prediction a = predict(*predictor, 0);
    const Prediction b = predict(*predictor, 1'700'000'000'123'456'789);
    check_close(a.translation, b.translation, 1e-9);
    check_close(a.rotation, b.rotation, 1e-9);
    check_close(a.twist.linear, b.twist.linear, 1e-9);
  }
}

TEST_CASE("predictor: around a hit states on the same side of it are compared",
          "[consensus][analytic]") {
  // A bounce in the middle of the step that ends with sample 30. The remote bounced at the same
  // time, 2 cm aside and a little faster across; nobody knows whether its steps resolve it sooner
  // or later.
  const double speed = 4.0;
  const double bounce = 29.5 * kDt;
  Motion own;
  own.pose = [=](double t) {
    return Pose{Vec3(0.0, 0.0, speed * std::abs(t - bounce)), Quat::Identity()};
  };
  own.twist = [=](double t) {
    return Twist{Vec3(0.0, 0.0, t < bounce ? -speed : speed), Vec3::Zero()};
  };
  own.coupled = [](int i) { return i == 30; };
  const Vec3 offset(0.02, 0.0, 0.0);
  const Vec3 dv(0.0, 0.1, 0.0);
  for (const double steps : {27.5, 28.5, 29.2, 29.45, 29.55, 29.8, 30.2, 30.8, 32.0, 33.5}) {
    INFO("stamp at " << steps << " steps");
    StateUpdate update = update_at(own, 0, offset, dv);
    update.stamp = kOrigin + std::llround(1e9 * kDt * steps);
    update.pose.position = own.pose(steps * kDt).position + offset;
    update.twist.linear = own.twist(steps * kDt).linear + dv;
    const Prediction p = kLocal->predict(update, own.history(40), at_step(39));
    check_close(p.twist.linear, dv);
    // What touches something is not carried by differences of velocity.
    const bool touched = steps < 31.0;
    const double age = (39.0 - steps) * kDt;
    check_close(p.translation, touched ? offset : Vec3(offset + age * dv), 1e-9);
  }
  // Agreement is no hit, however hard it pulls.
  const Vec3 pull = 30.0 * dv;
  const Vec3 none = Vec3::Zero();
  own.twist = [=](double t) { return Twist{t < 29.5 * kDt ? none : pull, none}; };
  own.correction = [=](int i) { return Correction{.twist = {i == 30 ? pull : none, none}}; };
  StateUpdate update = update_at(own, 31, Vec3::Zero(), dv);
  check_close(kLocal->predict(update, own.history(40), at_step(39)).twist.linear, dv);
}

TEST_CASE("history: times outside are clamped to its ends, the oldest samples go", "[consensus]") {
  Motion own;
  own.pose = [](double t) { return Pose{Vec3(t, 0.0, 0.0), Quat::Identity()}; };
  own.twist = [](double) { return Twist{Vec3(1.0, 0.0, 0.0), Vec3::Zero()}; };
  constexpr int kCount = static_cast<int>(MotionHistory::kCapacity) + 50;
  const MotionHistory history = own.history(kCount);
  CHECK(history.at_time(kOrigin + 10'000 * kStep).pose.position.x() ==
        Approx((kCount - 1) * kDt).epsilon(1e-12));
  CHECK(history.at_time(0).pose.position.x() == Approx(50 * kDt).epsilon(1e-12));
  CHECK(history.at_time(kOrigin + 100 * kStep + kStep / 4).pose.position.x() ==
        Approx(100.25 * kDt).epsilon(1e-12));
}

}  // namespace
}  // namespace tandem::consensus::predictor_test
