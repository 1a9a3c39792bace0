// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measure/geometry.h"

#include <algorithm>
#include <cmath>

namespace tandem::bench {
namespace {

using pbd::Mat3;

/// Half width of a box along the axis.
double reach(const Mat3& axes, const Vec3& half, const Vec3& axis) {
  return (axes.transpose() * axis).cwiseAbs().dot(half);
}

}  // namespace

double box_box_gap(const Vec3& half_a, const Pose& a, const Vec3& half_b, const Pose& b) {
  const Mat3 ra = a.orientation.toRotationMatrix();
  const Mat3 rb = b.orientation.toRotationMatrix();
  const Vec3 d = b.position - a.position;
  double best = -HUGE_VAL;
  const auto try_axis = [&](const Vec3& axis) {
    best =
        std::max(best, std::abs(d.dot(axis)) - reach(ra, half_a, axis) - reach(rb, half_b, axis));
  };
  for (int i = 0; i < 3; ++i) {
    try_axis(ra.col(i));
    try_axis(rb.col(i));
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec3 axis = ra.col(i).cross(rb.col(j));
      const double length = axis.norm();
      if (length > 1e-6) try_axis(axis / length);
    }
  }
  return best;
}

double box_wall_gap(const Vec3& half, const Pose& pose, const Vec3& half_wall, const Pose& wall) {
  const Mat3 rw = wall.orientation.toRotationMatrix();
  const Mat3 r = pose.orientation.toRotationMatrix();
  const Vec3 d = rw.transpose() * (pose.position - wall.position);
  double best = -HUGE_VAL;
  for (int i = 0; i < 3; ++i) {
    best = std::max(best, std::abs(d[i]) - half_wall[i] - reach(r, half, rw.col(i)));
  }
  return best;
}

double sphere_box_gap(double radius, const Vec3& centre, const Vec3& half_wall, const Pose& wall) {
  const Vec3 out = wall.to_local(centre).cwiseAbs() - half_wall;
  const double outside = out.cwiseMax(0.0).norm();
  return (outside > 0.0 ? outside : out.maxCoeff()) - radius;
}

// Source: [ericson2005] Sec. 5.1.5.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + ab * (d1 / (d1 - d3));
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  }
  const double sum = va + vb + vc;
  return a + ab * (vb / sum) + ac * (vc / sum);
}

HeightSurface::HeightSurface(const MeshData& mesh)
    : bins_(kBins * kBins), low_(mesh.vertices.front()), high_(mesh.vertices.front()) {
  for (const Vec3& v : mesh.vertices) {
    low_ = low_.cwiseMin(v);
    high_ = high_.cwiseMax(v);
  }
  for (const auto& t : mesh.triangles) {
    const std::array<Vec3, 3> corners{mesh.vertices[t[0]], mesh.vertices[t[1]],
                                      mesh.vertices[t[2]]};
    const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Vec3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    for (std::size_t j = row(low.y()); j <= row(high.y()); ++j) {
      for (std::size_t i = column(low.x()); i <= column(high.x()); ++i) {
        bins_[j * kBins + i].push_back(static_cast<std::uint32_t>(triangles_.size()));
      }
    }
    triangles_.push_back(corners);
  }
}

std::size_t HeightSurface::column(double x) const {
  const double at = std::floor((x - low_.x()) / (high_.x() - low_.x()) * double(kBins));
  return static_cast<std::size_t>(std::clamp(at, 0.0, double(kBins - 1)));
}

std::size_t HeightSurface::row(double y) const {
  const double at = std::floor((y - low_.y()) / (high_.y() - low_.y()) * double(kBins));
  return static_cast<std::size_t>(std::clamp(at, 0.0, double(kBins - 1)));
}

std::optional<double> HeightSurface::height(double x, double y) const {
  if (x < low_.x() || x > high_.x() || y < low_.y() || y > high_.y()) return std::nullopt;
  for (const std::uint32_t t : bins_[row(y) * kBins + column(x)]) {
    const auto& [a, b, c] = triangles_[t];
    const auto side = [&](const Vec3& p, const Vec3& q) {
      return (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x());
    };
    const double wc = side(a, b);
    const double wa = side(b, c);
    const double wb = side(c, a);
    constexpr double kTouch = -1e-12;
    if (wa < kTouch || wb < kTouch || wc < kTouch) continue;
    return (wa * a.z() + wb * b.z() + wc * c.z()) / (wa + wb + wc);
  }
  return std::nullopt;
}

std::optional<double> HeightSurface::distance(const Vec3& p) const {
  constexpr double kFar = 1.0;
  const std::optional<double> above = height(p.x(), p.y());
  double best = kFar;
  for (std::size_t j = row(p.y() - kFar); j <= row(p.y() + kFar); ++j) {
    for (std::size_t i = column(p.x() - kFar); i <= column(p.x() + kFar); ++i) {
      for (const std::uint32_t t : bins_[j * kBins + i]) {
        const auto& [a, b, c] = triangles_[t];
        best = std::min(best, (closest_on_triangle(p, a, b, c) - p).norm());
      }
    }
  }
  if (best >= kFar) return std::nullopt;
  return above && *above > p.z() ? -best : best;
}

}  // namespace tandem::bench
