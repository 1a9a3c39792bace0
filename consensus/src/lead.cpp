// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "lead.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem::consensus {
namespace {

/// rad: leading grows from none to full between these angles.
constexpr double kFromAngle = 0.6;
constexpr double kToAngle = 1.2;
/// A follower that neighbours keep from turning pulls harder with time, so that a body wedged in
/// different ways is set right after some two seconds instead of never.
constexpr double kGrowth = 6.0;  // 1/s^2
/// ns: a difference that was not seen for longer is a new one.
constexpr SessionTime kPause = 100'000'000;

/// m: copies closer than this are left alone.
constexpr double kParted = 0.03;
constexpr double kFree = std::numeric_limits<double>::infinity();
/// What is missing has changed by this part of it: something happens. A share of 0.02 needs 0.3 s.
constexpr double kChange = 0.3;
constexpr SessionTime kPatience = 1'000'000'000;      // ns
constexpr SessionTime kTurnPatience = 3'000'000'000;  // ns, more than kGrowth takes

}  // namespace

double Lead::share(double share, double angle, bool follows, SessionTime now) {
  const double doubt = std::clamp((angle - kFromAngle) / (kToAngle - kFromAngle), 0.0, 1.0);
  if (!follows) return share * (1.0 - doubt);
  double waited = 0.0;
  if (doubt >= 0.5) {
    // Others that agree are asked in between and change nothing about the one that does not.
    if (last_ < now - kPause) since_ = now;
    last_ = now;
    waited = 1e-9 * static_cast<double>(now - since_);
  }
  const double strength = (1.0 + doubt) * (1.0 + doubt * kGrowth * waited * waited);
  return doubt > 0.0 ? 1.0 - std::pow(1.0 - share, strength) : share;
}

bool Lead::parted(const pbd::Vec3& missing, const pbd::Vec3& turn, bool blocked, SessionTime now) {
  // About half a turn the axis changes its sign at random: only the angle is compared.
  const pbd::Vec3 angle(turn.norm(), 0.0, 0.0);
  const bool apart = apart_.look(missing, blocked ? kParted : kFree, kPatience, now);
  return turned_.look(angle, kToAngle, kTurnPatience, now) || apart;
}

bool Lead::Stuck::look(const pbd::Vec3& missing, double least, SessionTime patience,
                       SessionTime now) {
  if (missing.squaredNorm() < least * least) {
    waits_ = 0;
    if (together_ == 0) together_ = now;
    if (now - together_ >= kPatience) in_vain_.setZero();
    return false;
  }
  together_ = 0;
  if (waits_ == 0 || (missing - missed_).norm() > kChange * missed_.norm()) {
    waits_ = now;
    missed_ = missing;
  }
  if (now - waits_ < patience) return false;
  waits_ = 0;
  if ((missing - in_vain_).norm() <= kChange * in_vain_.norm()) return false;
  in_vain_ = missing;
  return true;
}

}  // namespace tandem::consensus
