// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/pose_arbiter.h"

#include <algorithm>
#include <limits>

namespace tandem::consensus {
namespace {

/// m: copies closer than this are left alone.
constexpr double kParted = 0.03;
constexpr double kFree = std::numeric_limits<double>::infinity();
/// What is missing has changed by this part of it: something happens. A share of 0.02 needs 0.3 s.
constexpr double kChange = 0.3;
/// How long nothing is done: tests/consensus/jump_test.cpp, which fails without the first, and
/// where what was in vain is tried again.
constexpr SessionTime kPatience = 1'000'000'000;      // ns
constexpr SessionTime kTurnPatience = 3'000'000'000;  // ns, as an edge gives way slowly

}  // namespace

double PoseArbiter::weight(double weight, double angle, bool follows) {
  const double doubt = std::clamp((angle - kFromAngle) / (kToAngle - kFromAngle), 0.0, 1.0);
  const double left = 1.0 - doubt;
  return follows ? weight / left : weight * left;
}

bool PoseArbiter::parted(const pbd::Vec3& missing, const pbd::Vec3& turn, bool blocked,
                         SessionTime now) {
  // About half a turn the axis changes its sign at random: only the angle is compared.
  const pbd::Vec3 angle(turn.norm(), 0.0, 0.0);
  const bool apart = apart_.look(missing, blocked ? kParted : kFree, kPatience, now);
  return turned_.look(angle, kToAngle, kTurnPatience, now) || apart;
}

bool PoseArbiter::Stuck::look(const pbd::Vec3& missing, double least, SessionTime patience,
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
