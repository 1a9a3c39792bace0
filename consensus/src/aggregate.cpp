// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/aggregate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tandem/consensus/influence.h"

namespace tandem::consensus {
namespace {

using pbd::Quat;
using pbd::Vec3;

/// A quaternion or a sum of such, (w, x, y, z). Plain arrays: the order of additions, and so the
/// bits, do not depend on how a library vectorises.
using Vec4 = std::array<double, 4>;
using Mat4 = std::array<Vec4, 4>;

constexpr Vec4 kIdentity = {1.0, 0.0, 0.0, 0.0};

/// Two eigenvalues closer than this, relative to the larger, leave the average open.
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
  return v * (2.0 * std::atan2(sine, sign * r[0]) / sine);
}

/// q as seen from `local`: r local = q, on the half sphere around no rotation. In this frame the
/// local orientation is (1, 0, 0, 0), and small weights leave small vector parts with all digits.
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

Vec4 normalized(const Vec4& v) {
  const double norm = std::sqrt(dot(v, v));
  return {v[0] / norm, v[1] / norm, v[2] / norm, v[3] / norm};
}

Vec4 times(const Mat4& m, const Vec4& v) {
  return {dot(m[0], v), dot(m[1], v), dot(m[2], v), dot(m[3], v)};
}

/// Dominant eigenvector by power iteration from `start`. Converges by a factor of at least 100 per
/// iteration where all states lie within kPowerSpread.
Vec4 dominant_by_power(const Mat4& m, const Vec4& start) {
  constexpr int kIterations = 10;
  constexpr double kConverged = 1e-28;  // square of the change
  Vec4 u = normalized(start);
  for (int i = 0; i < kIterations; ++i) {
    const Vec4 next = normalized(times(m, u));
    double change = 0.0;
    for (std::size_t k = 0; k < 4; ++k) change += (next[k] - u[k]) * (next[k] - u[k]);
    u = next;
    if (change < kConverged) break;
  }
  return u;
}

/// One Jacobi rotation: makes a[p][q] zero and turns the eigenvectors (columns of v) along.
void jacobi_rotate(Mat4& a, Mat4& v, std::size_t p, std::size_t q) {
  const double tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
  // The smaller root of t^2 + 2 tau t - 1; an infinite tau gives t = 0.
  const double t = (tau >= 0.0 ? 1.0 : -1.0) / (std::abs(tau) + std::sqrt(1.0 + tau * tau));
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  const double s = t * c;
  for (std::size_t k = 0; k < 4; ++k) {
    const double kp = a[k][p];
    const double kq = a[k][q];
    a[k][p] = c * kp - s * kq;
    a[k][q] = s * kp + c * kq;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const double pk = a[p][k];
    const double qk = a[q][k];
    a[p][k] = c * pk - s * qk;
    a[q][k] = s * pk + c * qk;
    const double vp = v[k][p];
    const double vq = v[k][q];
    v[k][p] = c * vp - s * vq;
    v[k][q] = s * vp + c * vq;
  }
}

/// Dominant eigenvector of a symmetric positive semidefinite matrix by cyclic Jacobi rotations, on
/// the half sphere around no rotation.
/// @param[out] open  whether the two largest eigenvalues are the same
Vec4 dominant_exact(Mat4 a, bool& open) {
  constexpr int kSweeps = 12;
  Mat4 v{};
  for (std::size_t k = 0; k < 4; ++k) v[k][k] = 1.0;
  const double scale = a[0][0] + a[1][1] + a[2][2] + a[3][3];
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double off = 0.0;
    for (std::size_t p = 0; p < 3; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        off = std::max(off, std::abs(a[p][q]));
        if (a[p][q] != 0.0) jacobi_rotate(a, v, p, q);
      }
    }
    if (off <= std::numeric_limits<double>::epsilon() * 1e-4 * scale) break;
  }
  std::size_t best = 0;
  for (std::size_t k = 1; k < 4; ++k) {
    if (a[k][k] > a[best][best]) best = k;
  }
  open = false;
  for (std::size_t k = 0; k < 4; ++k) {
    if (k != best && a[best][best] - a[k][k] <= kOpen * a[best][best]) open = true;
  }
  const double sign = v[0][best] < 0.0 ? -1.0 : 1.0;
  return normalized({sign * v[0][best], sign * v[1][best], sign * v[2][best], sign * v[3][best]});
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
  return v * (std::atan2(sine, cosine) / half_sine);
}

/// What a rotation average comes to.
struct MeanRotation {
  Vec3 correction = Vec3::Zero();  ///< rad, from the local orientation to q* of Eq. 2
  Quat remote = Quat::Identity();  ///< mean of the remote states alone
};

/// Estimates that count: weight(i) is 0 for the others. Owners count 1 each, and nobody else does.
class Weights {
 public:
  Weights(std::span<const PeerEstimate> estimates) : estimates_(estimates) {
    for (const PeerEstimate& e : estimates_) owned_ = owned_ || e.share >= 1.0;
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
      const double w = (*this)[i];
      if (!(w > 0.0)) continue;
      total_ += w;
      ++used_;
      if (used_ == 1 || w > (*this)[heaviest_]) heaviest_ = i;
    }
  }

  double operator[](std::size_t i) const {
    if (owned_) return estimates_[i].share >= 1.0 ? 1.0 : 0.0;
    return weight_of_share(estimates_[i].share);
  }
  double total() const { return total_; }
  int used() const { return used_; }
  bool owned() const { return owned_; }
  std::size_t heaviest() const { return heaviest_; }
  /// Of the local state, on the same scale.
  double local() const { return owned_ ? 0.0 : 1.0; }

 private:
  std::span<const PeerEstimate> estimates_;
  double total_ = 0.0;
  int used_ = 0;
  bool owned_ = false;
  std::size_t heaviest_ = 0;
};

/// Largest angles between states that count.
struct Spread {
  double remote = 0.0;  ///< rad, between remote states
  double all = 0.0;     ///< rad, the local state included
};

Spread spread_of(const Quat& local, std::span<const PeerEstimate> estimates,
                 const Weights& weights) {
  double remote = 1.0;  // smallest cosines of half the angles
  double all = 1.0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (!(weights[i] > 0.0)) continue;
    const Quat& q = estimates[i].pose.orientation;
    all = std::min(all, std::abs(dot(local, q)));
    for (std::size_t j = 0; j < i; ++j) {
      if (!(weights[j] > 0.0)) continue;
      remote = std::min(remote, std::abs(dot(q, estimates[j].pose.orientation)));
    }
  }
  return {2.0 * std::acos(remote), 2.0 * std::acos(std::min(all, remote))};
}

/// The average over two or more remote states close enough to be averaged.
MeanRotation mean_of_many(const Quat& local, std::span<const PeerEstimate> estimates,
                          const Weights& weights, bool cheap) {
  Mat4 remote{};
  Vec4 sum{};
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const double w = weights[i];
    if (!(w > 0.0)) continue;
    const Vec4 r = relative_to(local, estimates[i].pose.orientation);
    add_outer(remote, r, w);
    for (std::size_t k = 0; k < 4; ++k) sum[k] += w * r[k];
  }
  Mat4 all = remote;
  add_outer(all, kIdentity, weights.local());

  bool open = false;
  const Vec4 u_remote = cheap ? dominant_by_power(remote, sum) : dominant_exact(remote, open);
  MeanRotation mean;
  mean.remote = from_relative(local, u_remote);
  if (weights.owned()) {
    mean.correction = log_rotation(u_remote);
    return mean;
  }
  sum[0] += weights.local();
  const Vec4 u_all = cheap ? dominant_by_power(all, sum) : dominant_exact(all, open);
  if (!open) mean.correction = log_rotation(u_all);
  return mean;
}

RotationMean choose(const Weights& weights, const Spread& spread) {
  if (weights.used() == 1) return RotationMean::Single;
  if (spread.remote > kMeanSpread) return RotationMean::Heaviest;
  return spread.all > kPowerSpread ? RotationMean::Exact : RotationMean::Power;
}

}  // namespace

bool fuse(const pbd::Pose& local, std::span<PeerEstimate> estimates, pbd::PoseTarget& target,
          FusionInfo* info) {
  const auto by_peer = [](const PeerEstimate& a, const PeerEstimate& b) { return a.peer < b.peer; };
  if (!std::is_sorted(estimates.begin(), estimates.end(), by_peer)) {
    std::sort(estimates.begin(), estimates.end(), by_peer);
  }
  const Weights weights(estimates);
  if (weights.used() == 0) return false;

  target.share = weights.owned() ? 1.0 : share_of_weight(weights.total());
  target.pose.position = Vec3::Zero();
  target.twist = {};
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const PeerEstimate& e = estimates[i];
    const double part = weights[i] / weights.total();
    if (!(part > 0.0)) continue;
    target.pose.position += part * e.pose.position;
    target.twist.linear += part * e.twist.linear;
    target.twist.angular += part * e.twist.angular;
  }

  const Quat& q_local = local.orientation;
  const Spread spread = spread_of(q_local, estimates, weights);
  const RotationMean how = choose(weights, spread);
  MeanRotation mean;
  if (how == RotationMean::Single || how == RotationMean::Heaviest) {
    mean.remote = estimates[weights.heaviest()].pose.orientation;
    const double weight =
        weights.owned() ? std::numeric_limits<double>::infinity() : weights[weights.heaviest()];
    mean.correction = mean_with_single(relative_to(q_local, mean.remote), weight);
  } else {
    mean = mean_of_many(q_local, estimates, weights, how == RotationMean::Power);
  }
  target.pose.orientation = mean.remote;
  target.rotation_error = mean.correction / target.share;
  target.use_rotation_error = true;

  if (info != nullptr) {
    info->used = weights.used();
    info->weight = weights.owned() ? std::numeric_limits<double>::infinity() : weights.total();
    info->spread = spread.all;
    info->rotation = how;
  }
  return true;
}

}  // namespace tandem::consensus
