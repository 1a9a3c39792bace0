// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/predictor.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

using pbd::Vec3;

double seconds(SessionTime ns) { return 1e-9 * static_cast<double>(ns); }

/// Stamped poses further apart than this (m, rad) are not carried by own motion any more: what
/// moves here need not move there, and a cube that came to rest on another face falls back the
/// other way. Fades out from the first to the second.
constexpr double kFadeFrom = 0.10;
constexpr double kFadeTo = 0.30;
constexpr double kFadeFromAngle = 0.35;
constexpr double kFadeToAngle = 0.70;

/// m/s^2: a body that changes its velocity faster than this within a step was hit.
constexpr double kHitAcceleration = 40.0;

double ramp(double value, double from, double to) {
  return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

void add(pbd::Twist& sum, const pbd::Twist& value, double scale = 1.0) {
  sum.linear += scale * value.linear;
  sum.angular += scale * value.angular;
}

pbd::Twist difference(const pbd::Twist& a, const pbd::Twist& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}

class EulerPredictor final : public Predictor {
 public:
  explicit EulerPredictor(pbd::TargetMotion motion) : motion_(motion) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    const double age = seconds(context.now - update.stamp);
    const MotionSample& here = own.newest();
    const pbd::Quat there = pbd::rotated(update.pose.orientation, age * update.twist.angular);
    return {.translation = update.pose.position + age * update.twist.linear - here.pose.position,
            .rotation = pbd::rotation_between(here.pose.orientation, there),
            .twist = difference(update.twist, here.twist),
            .motion = update.flags.owner_driven ? pbd::TargetMotion::Inertial : motion_};
  }
  double gain() const override { return 1.0; }

 private:
  pbd::TargetMotion motion_;
};

/// Legend: t the stamp, A the age, x_i own, x_j remote, D what agreement has added to x_i since t,
/// r = share there / share here. The remote has meanwhile moved towards me as I towards it, so by
/// symmetry r D is taken off as well:
///   coupled:  e = x_j(t) - x_i(t) - (1 + r) D
///   free:     the same, and velocities: e += A (v_j - v_i)(t) - (1 + r) V
/// with V the way that velocity agreement since t has added. x_j(now) is never computed: both
/// bodies feel the same forces, and these cancel.
class LocalMotionPredictor final : public Predictor {
 public:
  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    // Moved by hand: nothing that happens to the body here happens there.
    if (update.flags.owner_driven) return linear_.predict(update, own, context);

    const MotionSample& now = own.newest();
    MotionSample then = own.at_time(update.stamp);
    const double age = std::max(0.0, seconds(context.now - update.stamp));
    // A peer whose steps end a little later than mine stamps ahead of me.
    const double ahead = std::max(0.0, seconds(update.stamp - now.time));
    then.pose.position += ahead * now.twist.linear;
    then.pose.orientation = pbd::rotated(then.pose.orientation, ahead * now.twist.angular);
    const double both = 1.0 + context.mirrored_share / std::max(1, context.peers);
    const Vec3 apart = update.pose.position - then.pose.position;
    const Vec3 turned_apart = pbd::rotation_between(then.pose.orientation, update.pose.orientation);
    const pbd::Twist closing =
        own.hit_near(update.stamp) ? pbd::Twist{} : difference(update.twist, then.twist);
    const pbd::Twist agreed = difference(now.agreed, then.agreed);

    Prediction prediction;
    prediction.translation = apart - both * (now.displaced - then.displaced);
    // A turn apart at the stamp has since been carried round by the body's own turning.
    const pbd::Quat own_turn = now.pose.orientation * then.pose.orientation.conjugate();
    prediction.rotation = own_turn * turned_apart - both * (now.turned - then.turned);
    prediction.twist = difference(closing, {both * agreed.linear, both * agreed.angular});

    const bool coupled =
        update.flags.in_contact || update.flags.held || own.coupled_since(update.stamp);
    if (!coupled) {
      // V = sum dv_k (now - t_k) = now sum dv_k - sum dv_k t_k
      const double t = now.elapsed;
      const pbd::Twist moment = difference(now.agreed_moment, then.agreed_moment);
      prediction.translation += age * closing.linear - both * (t * agreed.linear - moment.linear);
      prediction.rotation += age * closing.angular - both * (t * agreed.angular - moment.angular);
    }
    fade(update, now,
         std::max(ramp(apart.norm(), kFadeFrom, kFadeTo),
                  ramp(turned_apart.norm(), kFadeFromAngle, kFadeToAngle)),
         prediction);
    return prediction;
  }
  double gain() const override { return 2.0; }

 private:
  /// Towards the remote state as it was stamped, not carried on at all.
  static void fade(const StateUpdate& update, const MotionSample& now, double fraction,
                   Prediction& prediction) {
    if (fraction == 0.0) return;
    const auto blend = [fraction](Vec3& value, const Vec3& raw) {
      value += fraction * (raw - value);
    };
    blend(prediction.translation, update.pose.position - now.pose.position);
    blend(prediction.rotation,
          pbd::rotation_between(now.pose.orientation, update.pose.orientation));
    const pbd::Twist raw = difference(update.twist, now.twist);
    blend(prediction.twist.linear, raw.linear);
    blend(prediction.twist.angular, raw.angular);
  }

  EulerPredictor linear_{pbd::TargetMotion::Inertial};
};

}  // namespace

void MotionHistory::push(SessionTime time, const pbd::Pose& pose, const pbd::Twist& twist,
                         const pbd::Correction& correction, bool coupled) {
  if (count_ == 0) origin_ = time;
  sum_.time = time;
  sum_.elapsed = seconds(time - origin_);
  sum_.pose = pose;
  sum_.twist = twist;
  sum_.displaced += correction.translation;
  sum_.turned += correction.rotation;
  add(sum_.agreed, correction.twist);
  add(sum_.agreed_moment, correction.twist, sum_.elapsed);
  sum_.coupled = coupled;
  samples_[head_] = sum_;
  head_ = (head_ + 1) % kCapacity;
  count_ = std::min(count_ + 1, kCapacity);
}

MotionSample MotionHistory::at_time(SessionTime time) const {
  std::size_t age = 0;
  while (age + 1 < count_ && at(age).time > time) ++age;
  const MotionSample& before = at(age);
  if (age == 0 || before.time >= time) return before;
  const MotionSample& after = at(age - 1);
  const double f =
      static_cast<double>(time - before.time) / static_cast<double>(after.time - before.time);
  const auto mix = [f](const Vec3& a, const Vec3& b) { return Vec3(a + f * (b - a)); };
  const auto mix_twist = [&mix](const pbd::Twist& a, const pbd::Twist& b) {
    return pbd::Twist{mix(a.linear, b.linear), mix(a.angular, b.angular)};
  };
  MotionSample sample = before;
  sample.time = time;
  sample.elapsed = before.elapsed + f * (after.elapsed - before.elapsed);
  sample.pose.position = mix(before.pose.position, after.pose.position);
  sample.pose.orientation =
      pbd::rotated(before.pose.orientation,
                   f * pbd::rotation_between(before.pose.orientation, after.pose.orientation));
  sample.twist = mix_twist(before.twist, after.twist);
  sample.displaced = mix(before.displaced, after.displaced);
  sample.turned = mix(before.turned, after.turned);
  sample.agreed = mix_twist(before.agreed, after.agreed);
  sample.agreed_moment = mix_twist(before.agreed_moment, after.agreed_moment);
  sample.coupled = before.coupled || after.coupled;
  return sample;
}

bool MotionHistory::coupled_since(SessionTime time) const {
  for (std::size_t age = 0; age < count_; ++age) {
    if (at(age).coupled) return true;
    if (at(age).time <= time) break;
  }
  return false;
}

bool MotionHistory::hit_near(SessionTime time) const {
  std::size_t age = 0;
  while (age + 1 < count_ && at(age).time > time) ++age;
  // at(age) is the last sample before: its own step, the one that `time` is in, and the next.
  const std::size_t first = age >= 2 ? age - 2 : 0;
  for (std::size_t k = first; k <= age && k + 1 < count_; ++k) {
    const MotionSample& before = at(k + 1);
    const MotionSample& after = at(k);
    const Vec3 jump = difference(after.twist, before.twist).linear -
                      difference(after.agreed, before.agreed).linear;
    if (jump.norm() > kHitAcceleration * (after.elapsed - before.elapsed)) return true;
  }
  return false;
}

std::unique_ptr<Predictor> make_euler_predictor() {
  return std::make_unique<EulerPredictor>(pbd::TargetMotion::WithBody);
}
std::unique_ptr<Predictor> make_local_motion_predictor() {
  return std::make_unique<LocalMotionPredictor>();
}

}  // namespace tandem::consensus
