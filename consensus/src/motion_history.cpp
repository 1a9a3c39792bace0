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

void add(pbd::Twist& sum, const pbd::Twist& value, double scale = 1.0) {
  sum.linear += scale * value.linear;
  sum.angular += scale * value.angular;
}

/// The age in samples of the newest one that is not later than `time`, the oldest where all are.
/// Steps are about equally long, so that a guess is seldom off by more than one.
template <class TimeAt>
std::size_t age_of(SessionTime time, std::size_t count, const TimeAt& time_at) {
  std::size_t age = 0;
  if (count > 1 && time < time_at(0)) {
    const SessionTime step = std::max<SessionTime>(time_at(0) - time_at(1), 1);
    age = std::min(static_cast<std::size_t>((time_at(0) - time) / step), count - 1);
  }
  while (age > 0 && time_at(age - 1) <= time) --age;
  while (age + 1 < count && time_at(age) > time) ++age;
  return age;
}

}  // namespace

void MotionHistory::push(SessionTime time, const pbd::Pose& pose, const pbd::Twist& twist,
                         const pbd::Correction& correction, bool coupled, bool driven) {
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
  free_for_ = coupled ? 0 : free_for_ + 1;
  undriven_for_ = driven ? 0 : undriven_for_ + 1;
  samples_[head_] = sum_;
  head_ = (head_ + 1) % kCapacity;
  count_ = std::min(count_ + 1, kCapacity);
}

MotionSample MotionHistory::at_time(SessionTime time) const {
  const std::size_t age = age_of(time, count_, [this](std::size_t i) { return at(i).time; });
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
  if (!before.coupled && !after.coupled) {
    // The cubic that has both velocities, exact in free fall; what agreement moved goes straight.
    const double dt = after.elapsed - before.elapsed;
    const Vec3 way =
        after.pose.position - before.pose.position - (after.displaced - before.displaced);
    sample.pose.position +=
        f * (1.0 - f) *
        ((1.0 - f) * (dt * before.twist.linear - way) - f * (dt * after.twist.linear - way));
  }
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

bool MotionHistory::within(SessionTime time, const pbd::Quat& q, double angle) const {
  const std::size_t age = age_of(time, count_, [this](std::size_t i) { return at(i).time; });
  // Quaternions are apart by half of the angle. What lies between two samples near q is near q.
  const double least = std::cos(0.5 * angle);
  return std::abs(at(age).pose.orientation.dot(q)) > least &&
         (age == 0 || std::abs(at(age - 1).pose.orientation.dot(q)) > least);
}

void MotionHistory::prefetch(std::size_t age) const {
  constexpr std::size_t kLine = 64;
  const auto fetch = [](const MotionSample& sample) {
    const char* const bytes = reinterpret_cast<const char*>(&sample);
    for (std::size_t i = 0; i < sizeof(MotionSample); i += kLine) __builtin_prefetch(bytes + i);
  };
  if (count_ == 0) return;
  fetch(at(0));
  for (std::size_t k = std::max<std::size_t>(age, 1) - 1; k <= age + 1 && k < count_; ++k) {
    if (k > 0) fetch(at(k));
  }
}

bool MotionHistory::coupled_since(SessionTime time) const {
  return count_ > 0 &&
         free_for_ <= age_of(time, count_, [this](std::size_t i) { return at(i).time; });
}

bool MotionHistory::driven_since(SessionTime time) const {
  return undriven_for_ < count_ &&
         undriven_for_ <= age_of(time, count_, [this](std::size_t i) { return at(i).time; });
}

std::optional<MotionSample> MotionHistory::beside_hit(SessionTime time,
                                                      const Vec3& velocity) const {
  const std::size_t age = age_of(time, count_, [this](std::size_t i) { return at(i).time; });
  // at(age) is the last sample before: its own step, the one that `time` is in, and the next.
  const std::size_t first = age >= 2 ? age - 2 : 0;
  for (std::size_t k = first; k <= age && k + 1 < count_; ++k) {
    const MotionSample& before = at(k + 1);
    const MotionSample& after = at(k);
    const Vec3 jump = difference(after.twist, before.twist).linear -
                      difference(after.agreed, before.agreed).linear;
    if (jump.norm() <= kHitAcceleration * (after.elapsed - before.elapsed)) continue;
    const bool has_it_behind = (velocity - after.twist.linear).squaredNorm() <
                               (velocity - before.twist.linear).squaredNorm();
    const MotionSample& side = has_it_behind ? after : before;
    MotionSample sample = at_time(time);
    const double dt = seconds(time - side.time);
    sample.pose.position = side.pose.position + dt * side.twist.linear;
    sample.pose.orientation = pbd::rotated(side.pose.orientation, dt * side.twist.angular);
    sample.twist = side.twist;
    return sample;
  }
  return std::nullopt;
}

}  // namespace tandem::consensus
