// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_lcp.h"

#include <Eigen/LU>
#include <random>

#include "support/catch.h"

namespace contact_lcp_test {

using namespace tandem::pbd;

namespace {

/// A manifold's mobility, multipliers and velocities, drawn at random.
struct Problem {
  FourByFour B = FourByFour::Zero();
  Four z = Four::Zero();
  Four e = Four::Zero();

  Problem(std::mt19937& random, int count, int rank) {
    std::normal_distribution<double> normal;
    for (int k = 0; k < rank; ++k) {
      Four row = Four::Zero();
      for (int i = 0; i < count; ++i) row[i] = normal(random);
      B += (row.matrix() * row.matrix().transpose()).array();
    }
    for (int i = 0; i < count; ++i) {
      z[i] = std::max(0.0, normal(random));
      e[i] = normal(random);
    }
  }
};

/// The answer by trying all sets of loaded points: the one that is right in all signs.
Four brute_force(int count, const Problem& p) {
  for (unsigned set = 0; set < (1u << count); ++set) {
    Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
    Eigen::Vector4d r = -p.z.matrix();
    for (int i = 0; i < count; ++i) {
      if (!(set >> i & 1u)) continue;
      M.row(i) = p.B.matrix().row(i);
      r[i] = -p.e[i];
    }
    const Four d = M.fullPivLu().solve(r).array();
    const Four velocity = p.e + (p.B.matrix() * d.matrix()).array();
    bool right = true;
    for (int i = 0; i < count; ++i) {
      right = right && p.z[i] + d[i] >= -1e-9 && velocity[i] >= -1e-9;
    }
    if (right) return d;
  }
  FAIL("no set of loaded points is right");
  return Four::Zero();
}

}  // namespace

TEST_CASE("contact: the points of a manifold are solved as trying all sets does", "[pbd][lcp]") {
  std::mt19937 random(7);
  for (int count = 1; count <= 4; ++count) {
    for (int trial = 0; trial < 2000; ++trial) {
      const Problem p(random, count, 6);
      const Four expected = brute_force(count, p);
      const Four d = solve_lcp(count, p.B, p.z, p.e);
      CAPTURE(count, trial);
      // The ridge makes a share of 1e-6 of the difference, times the condition of B.
      const double condition =
          p.B.matrix().topLeftCorner(count, count).inverse().norm() * p.B.matrix().norm();
      CHECK((d - expected).abs().maxCoeff() <= 1e-5 * condition * (1.0 + p.z.maxCoeff()));
    }
  }
}

TEST_CASE("contact: points whose share of a load is open converge to one that holds",
          "[pbd][lcp]") {
  std::mt19937 random(11);
  for (int rank = 1; rank <= 3; ++rank) {
    for (int trial = 0; trial < 500; ++trial) {
      Problem p(random, 4, rank);
      // Velocities that some impulses can stop.
      const Four way(1.0, -2.0, 0.5, 0.3);
      p.e = (p.B.matrix() * way.matrix()).array();
      const double fastest = p.e.abs().maxCoeff();
      for (int repeat = 0; repeat < 30; ++repeat) {
        const Four d = solve_lcp(4, p.B, p.z, p.e);
        p.z += d;
        p.e += (p.B.matrix() * d.matrix()).array();
      }
      CAPTURE(rank, trial);
      CHECK(p.z.minCoeff() >= 0.0);
      CHECK(p.e.minCoeff() >= -1e-6 * fastest);
      CHECK((p.z * p.e).abs().maxCoeff() <= 1e-6 * fastest * p.z.maxCoeff());
    }
  }
}

}  // namespace contact_lcp_test
