// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/aggregate.h"

#include <array>
#include <cmath>
#include <limits>

#include "common/ranges.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/portable.h"

namespace tandem::consensus {
namespace {

using pbd::Quat;
using pbd::Vec3;

/// A quaternion or a sum of quaternions, (w, x, y, z). Plain arrays fix the order of additions, so
/// that the bits do not depend on a library's vectorisation.
using Vec4 = std::array<double, 4>;
using Mat4 = std::array<Vec4, 4>;

/// If two eigenvalues are closer than this, relative to the larger, the average is undetermined.
constexpr double kOpen = 1e-9;

double dot(const Vec4& a, const Vec4& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

double dot(const Quat& a, const Quat& b) {
  return a.w() * b.w() + a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

/// Rotation vector of a unit quaternion, at most half a turn.
Vec3 log_rotation(const Vec4& r) {
  const double sign = r[0] < 0.0 ? -1.0 : 1.0;
  const Vec3 v(sign * r[1], sign * r[2], sign * r[3]);
  const double sine = v.norm();
  if (sine == 0.0) return Vec3::Zero();
  return v * (2.0 * pbd::portable::atan2(sine, sign * r[0]) / sine);
}

/// q relative to `local`: r local = q, with r.w >= 0. In this frame the local orientation is (1, 0,
/// 0, 0), and small weights keep all digits of small vector parts.
Vec4 relative_to(const Quat& local, const Quat& q) {
  const Quat r = q * local.conjugate();
  const double sign = r.w() < 0.0 ? -1.0 : 1.0;
  return {sign * r.w(), sign * r.x(), sign * r.y(), sign * r.z()};
}

Quat from_relative(const Quat& local, const Vec4& r) {
  return (Quat(r[0], r[1], r[2], r[3]) * local).normalized();
}

void add_outer(Mat4& m, const Vec4& r, double weight) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) m[i][j] += weight * r[i] * r[j];
  }
}

/// Dominant eigenvector of a symmetric positive semidefinite matrix, with w >= 0. Repeated squaring
/// turns the matrix into the projection on that vector: four squarings if the states agree within
/// 20 degrees.
/// @param[out] open  whether the two largest eigenvalues are the same, to 1e-9
Vec4 dominant(Mat4 m, bool& open) {
  constexpr int kSquarings = 35;
  constexpr double kLeft = 1e-14;  // bound on the other eigenvalues; its square is below rounding
  open = true;
  for (int squared = 0; squared < kSquarings && open; ++squared) {
    const double scale = 1.0 / (m[0][0] + m[1][1] + m[2][2] + m[3][3]);
    for (Vec4& row : m) {
      for (double& entry : row) entry *= scale;
    }
    const Mat4 root = m;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i; j < 4; ++j) m[i][j] = m[j][i] = dot(root[i], root[j]);
    }
    open = m[0][0] + m[1][1] + m[2][2] + m[3][3] < 1.0 - kLeft;
  }
  std::size_t best = 0;
  for (std::size_t k = 1; k < 4; ++k) {
    if (m[k][k] > m[best][best]) best = k;
  }
  const double scale = (m[best][0] < 0.0 ? -1.0 : 1.0) / std::sqrt(dot(m[best], m[best]));
  return {scale * m[best][0], scale * m[best][1], scale * m[best][2], scale * m[best][3]};
}

/// Rotation vector from the local orientation (weight 1) to its mean with one state `r` of weight
/// w: about r's axis by atan2(w sin t, 1 + w cos t), t = r's angle.
Vec3 mean_with_single(const Vec4& r, double w) {
  if (std::isinf(w)) return log_rotation(r);
  const Vec3 v(r[1], r[2], r[3]);
  const double half_sine = v.norm();
  if (half_sine == 0.0) return Vec3::Zero();
  const double sine = w * 2.0 * r[0] * half_sine;
  const double cosine = 1.0 + w * (r[0] * r[0] - half_sine * half_sine);
  if (std::abs(sine) + std::abs(cosine) <= kOpen * (1.0 + w)) return Vec3::Zero();
  return v * (pbd::portable::atan2(sine, cosine) / half_sine);
}

/// Result of a rotation average.
struct MeanRotation {
  Vec3 correction = Vec3::Zero();  ///< rad, from the local orientation to q* of Eq. 2
  Quat remote = Quat::Identity();  ///< mean of the remote states alone
};

/// Sums over the weights: sets PeerEstimate::weight. If there are owners, each counts 1 and no
/// other state counts.
struct Tally {
  double total = 0.0;
  int used = 0;
  bool owned = false;
  std::size_t heaviest = 0;
};

Tally weigh(std::span<PeerEstimate> estimates) {
  Tally tally;
  for (const PeerEstimate& e : estimates) tally.owned = tally.owned || e.share >= 1.0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    PeerEstimate& e = estimates[i];
    e.weight = weight_of_share(e.share);
    if (tally.owned) e.weight = e.share >= 1.0 ? 1.0 : 0.0;
    if (!(e.weight > 0.0)) continue;
    tally.total += e.weight;
    ++tally.used;
    if (tally.used == 1 || e.weight > estimates[tally.heaviest].weight) tally.heaviest = i;
  }
  return tally;
}

constexpr double kMeanCosine = 0.8660254037844386;  // cosine of half of 60 degrees

/// Whether all states that count are within 60 degrees of each other.
bool have_mean(std::span<const PeerEstimate> estimates) {
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (!(estimates[i].weight > 0.0)) continue;
    for (std::size_t j = 0; j < i; ++j) {
      if (!(estimates[j].weight > 0.0)) continue;
      const double cosine = dot(estimates[i].pose.orientation, estimates[j].pose.orientation);
      if (std::abs(cosine) < kMeanCosine) return false;
    }
  }
  return true;
}

/// The average of two or more remote states close enough to have one.
MeanRotation mean_of_many(const Quat& local, std::span<const PeerEstimate> estimates, bool owned) {
  Mat4 m{};
  for (const PeerEstimate& e : estimates) {
    if (e.weight > 0.0) add_outer(m, relative_to(local, e.pose.orientation), e.weight);
  }
  bool open = false;
  const Vec4 remote = dominant(m, open);
  MeanRotation mean;
  mean.remote = from_relative(local, remote);
  if (owned) {
    mean.correction = log_rotation(remote);
    return mean;
  }
  m[0][0] += 1.0;  // the local state, (1, 0, 0, 0) with weight 1
  const Vec4 all = dominant(m, open);
  if (!open) mean.correction = log_rotation(all);
  return mean;
}

}  // namespace

bool fuse(const pbd::Pose& local, std::span<PeerEstimate> estimates, pbd::PoseTarget& target) {
  ranges::sort(estimates, &PeerEstimate::peer);
  const Tally tally = weigh(estimates);
  if (tally.used == 0) return false;

  target.share = tally.owned ? 1.0 : share_of_weight(tally.total);
  target.pose.position = Vec3::Zero();
  target.twist = {};
  for (const PeerEstimate& e : estimates) {
    if (!(e.weight > 0.0)) continue;
    const double part = e.weight / tally.total;
    target.pose.position += part * e.pose.position;
    target.twist.linear += part * e.twist.linear;
    target.twist.angular += part * e.twist.angular;
  }

  constexpr double kOwner = std::numeric_limits<double>::infinity();
  MeanRotation mean;
  if (tally.used == 1 || !have_mean(estimates)) {
    const PeerEstimate& heaviest = estimates[tally.heaviest];
    mean.remote = heaviest.pose.orientation;
    mean.correction = mean_with_single(relative_to(local.orientation, mean.remote),
                                       tally.owned ? kOwner : heaviest.weight);
  } else {
    mean = mean_of_many(local.orientation, estimates, tally.owned);
  }
  target.pose.orientation = mean.remote;
  target.rotation_error = mean.correction / target.share;
  target.use_rotation_error = true;
  return true;
}

}  // namespace tandem::consensus
