// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>

#include "predictors.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

using detail::difference;
using detail::seconds;
using pbd::Vec3;

/// m/s^2: a body that changes its velocity faster than this within a step was hit.
constexpr double kHitAcceleration = 40.0;

pbd::Twist sum(const pbd::Twist& a, const pbd::Twist& b, double scale) {
  return {a.linear + scale * b.linear, a.angular + scale * b.angular};
}

/// Whether the velocity changed between two samples by more than agreement and forces explain.
bool is_hit(const MotionSample& before, const MotionSample& after, double dt) {
  const Vec3 jump =
      difference(after.twist, before.twist).linear - difference(after.agreed, before.agreed).linear;
  return jump.norm() > kHitAcceleration * dt;
}

}  // namespace

void MotionHistory::push(SessionTime time, const pbd::Pose& pose, const pbd::Twist& twist,
                         const pbd::Correction& correction, bool coupled, bool driven) {
  if (count_ == 0) origin_ = time;
  const MotionSample& last = at(0);  // zeros at first
  MotionSample& sample = samples_[head_ * stride_];
  const double now = elapsed(time);
  sample.time = time;
  sample.pose = pose;
  sample.twist = twist;
  sample.displaced = last.displaced + correction.translation;
  sample.turned = last.turned + correction.rotation;
  sample.agreed = sum(last.agreed, correction.twist, 1.0);
  sample.agreed_moment = sum(last.agreed_moment, correction.twist, now);
  hits_[head_] = count_ > 0 && is_hit(last, sample, now - elapsed(last.time));
  coupled_[head_] = coupled;
  step_ = time - last.time;
  free_for_ = coupled ? 0 : free_for_ + 1;
  undriven_for_ = driven ? 0 : undriven_for_ + 1;
  head_ = (head_ + 1) % kCapacity;
  count_ = std::min(count_ + 1, kCapacity);
}

MotionHistory::Moment MotionHistory::moment(SessionTime time) const {
  std::size_t age = 0;
  // Steps are about equally long, so that a guess is seldom off by more than one.
  if (count_ > 1 && time < at(0).time) {
    const double steps = static_cast<double>(at(0).time - time) /
                         static_cast<double>(std::max<SessionTime>(step_, 1));
    age = static_cast<std::size_t>(std::min(std::ceil(steps), static_cast<double>(count_ - 1)));
  }
  while (age > 0 && at(age - 1).time <= time) --age;
  while (age + 1 < count_ && at(age).time > time) ++age;
  return {time, age};
}

MotionSample MotionHistory::at_time(const Moment& moment) const {
  const auto& [time, age] = moment;
  const MotionSample& before = at(age);
  if (age == 0 || before.time >= time) return before;
  const MotionSample& after = at(age - 1);
  const double f =
      static_cast<double>(time - before.time) / static_cast<double>(after.time - before.time);
  const auto mix = [f](const Vec3& a, const Vec3& b) { return Vec3(a + f * (b - a)); };
  const auto mix_twist = [&mix](const pbd::Twist& a, const pbd::Twist& b) {
    return pbd::Twist{mix(a.linear, b.linear), mix(a.angular, b.angular)};
  };
  const pbd::Vec3 turn = f * pbd::rotation_between(before.pose.orientation, after.pose.orientation);
  Vec3 position = mix(before.pose.position, after.pose.position);
  if (!coupled_[slot(age)] && !coupled_[slot(age - 1)]) {
    // The cubic that has both velocities, exact in free fall; what agreement moved goes straight.
    const double dt = seconds(after.time - before.time);
    const Vec3 way =
        after.pose.position - before.pose.position - (after.displaced - before.displaced);
    position +=
        f * (1.0 - f) *
        ((1.0 - f) * (dt * before.twist.linear - way) - f * (dt * after.twist.linear - way));
  }
  return {.time = time,
          .pose = {position, pbd::rotated(before.pose.orientation, turn)},
          .twist = mix_twist(before.twist, after.twist),
          .displaced = mix(before.displaced, after.displaced),
          .turned = mix(before.turned, after.turned),
          .agreed = mix_twist(before.agreed, after.agreed),
          .agreed_moment = mix_twist(before.agreed_moment, after.agreed_moment)};
}

bool MotionHistory::within(const Moment& moment, const pbd::Quat& q, double half_cosine) const {
  // Quaternions are apart by half of the angle. What lies between two samples near q is near q.
  return std::abs(at(moment.age).pose.orientation.dot(q)) > half_cosine &&
         (moment.age == 0 || std::abs(at(moment.age - 1).pose.orientation.dot(q)) > half_cosine);
}

pbd::Twist MotionHistory::pushed() const {
  if (count_ < 2) return {};
  const MotionSample& now = at(0);
  const MotionSample& then = at(1);
  return {now.twist.linear - then.twist.linear - (now.agreed.linear - then.agreed.linear),
          now.twist.angular - then.twist.angular - (now.agreed.angular - then.agreed.angular)};
}

std::optional<MotionSample> MotionHistory::beside_hit(const Moment& moment,
                                                      const Vec3& velocity) const {
  // at(age) is the last sample before: its own step, the one that the time is in, and the next.
  const std::size_t first = moment.age >= 2 ? moment.age - 2 : 0;
  for (std::size_t k = first; k <= moment.age && k + 1 < count_; ++k) {
    if (!hits_[slot(k)]) continue;
    const MotionSample& before = at(k + 1);
    const MotionSample& after = at(k);
    const bool has_it_behind = (velocity - after.twist.linear).squaredNorm() <
                               (velocity - before.twist.linear).squaredNorm();
    const MotionSample& side = has_it_behind ? after : before;
    MotionSample sample = at_time(moment);
    const double dt = seconds(moment.time - side.time);
    sample.pose.position = side.pose.position + dt * side.twist.linear;
    sample.pose.orientation = pbd::rotated(side.pose.orientation, dt * side.twist.angular);
    sample.twist = side.twist;
    return sample;
  }
  return std::nullopt;
}

}  // namespace tandem::consensus
