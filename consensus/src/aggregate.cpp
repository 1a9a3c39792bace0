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

/// Dominant eigenvector by power iteration from the aligned sum of states within kPowerSpread: each
/// iteration divides the error, below 1e-3 at the start, by at least 100. A fixed number of them
/// costs less than looking whether they are still needed.
Vec4 dominant_by_power(const Mat4& m, Vec4 u) {
  constexpr int kIterations = 5;
  // The dominant eigenvalue is nearly the trace, so that nothing has to be normalised on the way.
  const double scale = 1.0 / (m[0][0] + m[1][1] + m[2][2] + m[3][3]);
  for (int i = 0; i < kIterations; ++i) {
    u = times(m, u);
    for (double& component : u) component *= scale;
  }
  return normalized(u);
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
  a[p][q] = 0.0;  // up to rounding it was
  a[q][p] = 0.0;
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
    // Converges quadratically: what was below this is below rounding after the sweep.
    if (off <= 1e-9 * scale) break;
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

/// Who counts and how much: fills PeerEstimate::weight. Owners count 1 each, and nobody else does.
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

/// Smallest cosines of half the angle between two states that count.
struct Spread {
  double remote = 1.0;  ///< between remote states
  double all = 1.0;     ///< the local state included
};

Spread spread_of(const Quat& local, std::span<const PeerEstimate> estimates) {
  Spread spread;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (!(estimates[i].weight > 0.0)) continue;
    const Quat& q = estimates[i].pose.orientation;
    spread.all = std::min(spread.all, std::abs(dot(local, q)));
    for (std::size_t j = 0; j < i; ++j) {
      if (!(estimates[j].weight > 0.0)) continue;
      spread.remote = std::min(spread.remote, std::abs(dot(q, estimates[j].pose.orientation)));
    }
  }
  spread.all = std::min(spread.all, spread.remote);
  return spread;
}

constexpr double kPowerCosine = 0.984807753012208;  // of half of kPowerSpread
constexpr double kMeanCosine = 0.8660254037844386;  // of half of kMeanSpread

/// The average over two or more remote states close enough to be averaged.
MeanRotation mean_of_many(const Quat& local, std::span<const PeerEstimate> estimates,
                          const Tally& tally, const Spread& spread) {
  const Vec4 reference = relative_to(local, estimates[tally.heaviest].pose.orientation);
  Mat4 m{};
  Vec4 sum{};
  for (const PeerEstimate& e : estimates) {
    if (!(e.weight > 0.0)) continue;
    const Vec4 r = relative_to(local, e.pose.orientation);
    add_outer(m, r, e.weight);
    const double aligned = dot(r, reference) < 0.0 ? -e.weight : e.weight;
    for (std::size_t k = 0; k < 4; ++k) sum[k] += aligned * r[k];
  }
  bool open = false;
  const Vec4 remote =
      spread.remote >= kPowerCosine ? dominant_by_power(m, sum) : dominant_exact(m, open);
  MeanRotation mean;
  mean.remote = from_relative(local, remote);
  if (tally.owned) {
    mean.correction = log_rotation(remote);
    return mean;
  }
  m[0][0] += 1.0;  // the local state, (1, 0, 0, 0) with weight 1
  sum[0] += 1.0;
  const Vec4 all = spread.all >= kPowerCosine ? dominant_by_power(m, sum) : dominant_exact(m, open);
  if (!open) mean.correction = log_rotation(all);
  return mean;
}

RotationMean choose(const Tally& tally, const Spread& spread) {
  if (tally.used == 1) return RotationMean::Single;
  if (spread.remote < kMeanCosine) return RotationMean::Heaviest;
  const double relevant = tally.owned ? spread.remote : spread.all;
  return relevant < kPowerCosine ? RotationMean::Exact : RotationMean::Power;
}

/// The usual case: one other peer, that does not own the body. The general code gives the same
/// bits.
bool fuse_one(const pbd::Pose& local, PeerEstimate& estimate, pbd::PoseTarget& target) {
  estimate.weight = weight_of_share(estimate.share);
  if (!(estimate.weight > 0.0)) return false;
  target.share = share_of_weight(estimate.weight);
  target.pose = estimate.pose;
  target.twist = estimate.twist;
  target.rotation_error =
      mean_with_single(relative_to(local.orientation, estimate.pose.orientation), estimate.weight) /
      target.share;
  target.use_rotation_error = true;
  return true;
}

}  // namespace

bool fuse(const pbd::Pose& local, std::span<PeerEstimate> estimates, pbd::PoseTarget& target,
          FusionInfo* info) {
  if (info == nullptr && estimates.size() == 1 && estimates[0].share < 1.0) {
    return fuse_one(local, estimates[0], target);
  }
  const auto by_peer = [](const PeerEstimate& a, const PeerEstimate& b) { return a.peer < b.peer; };
  if (!std::is_sorted(estimates.begin(), estimates.end(), by_peer)) {
    std::sort(estimates.begin(), estimates.end(), by_peer);
  }
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
  const Spread spread = spread_of(local.orientation, estimates);
  const RotationMean how = choose(tally, spread);
  MeanRotation mean;
  if (how == RotationMean::Single || how == RotationMean::Heaviest) {
    const PeerEstimate& heaviest = estimates[tally.heaviest];
    mean.remote = heaviest.pose.orientation;
    mean.correction = mean_with_single(relative_to(local.orientation, mean.remote),
                                       tally.owned ? kOwner : heaviest.weight);
  } else {
    mean = mean_of_many(local.orientation, estimates, tally, spread);
  }
  target.pose.orientation = mean.remote;
  target.rotation_error = mean.correction / target.share;
  target.use_rotation_error = true;

  if (info != nullptr) {
    info->used = tally.used;
    info->weight = tally.owned ? kOwner : tally.total;
    info->spread = 2.0 * std::acos(spread.all);
    info->rotation = how;
  }
  return true;
}

}  // namespace tandem::consensus
