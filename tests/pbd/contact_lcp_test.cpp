// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_lcp.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <bit>
#include <cstdint>
#include <random>

#include "support/catch.h"

namespace contact_lcp_test {

using namespace tandem::pbd;

namespace {

using Batch = xsimd::batch<double, xsimd::default_arch>;
using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

/// Nearly normal, and the same with every standard library, whose distributions are not.
double normal(std::mt19937& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) * 0x1p-32;
  return sum;
}

/// A manifold's mobility, multipliers and velocities, drawn at random.
struct Problem {
  int count;
  Mat4 B = Mat4::Zero();
  Vec4 u = Vec4::Zero();  ///< loads that move nothing, of unit length
  Vec4 z = Vec4::Zero();
  Vec4 e = Vec4::Zero();

  Problem(std::mt19937& random, int points, int rank) : count(points) {
    for (int k = 0; k < rank; ++k) {
      Vec4 row = Vec4::Zero();
      for (int i = 0; i < count; ++i) row[i] = normal(random);
      B += row * row.transpose();
    }
    for (int i = 0; i < count; ++i) {
      z[i] = std::max(0.0, normal(random));
      e[i] = normal(random);
    }
  }
};

Vec4 first_lane(const kernel::Four<Batch>& all) {
  Vec4 out;
  for (std::size_t i = 0; i < 4; ++i) {
    Lanes lanes;
    kernel::store(all[i], lanes, 0);
    out[static_cast<Eigen::Index>(i)] = lanes[0];
  }
  return out;
}

/// The answers of the kernel to `first` in lane 0 and `other` in the others; that of lane 0.
Vec4 solve(const Problem& first, const Problem& other) {
  const auto both = [](double value, double others) {
    Lanes lanes;
    lanes.fill(others);
    lanes[0] = value;
    return kernel::load<Batch>(lanes, 0);
  };
  const auto four = [&](const Vec4& value, const Vec4& others) {
    kernel::Four<Batch> out;
    for (int i = 0; i < 4; ++i) out[static_cast<std::size_t>(i)] = both(value[i], others[i]);
    return out;
  };
  const auto entry = [&](int i, int j) { return both(first.B(i, j), other.B(i, j)); };
  std::array<kernel::Mask<Batch>, 4> there;
  for (int i = 0; i < 4; ++i) {
    there[static_cast<std::size_t>(i)] = both(first.count, other.count) > Batch(i);
  }
  const kernel::Four<Batch> d =
      kernel::solve_lcp<Batch>(there,
                               {entry(0, 0), entry(1, 0), entry(1, 1), entry(2, 0), entry(2, 1),
                                entry(2, 2), entry(3, 0), entry(3, 1), entry(3, 2), entry(3, 3)},
                               four(first.z, other.z), four(first.e, other.e));
  return first_lane(d);
}

/// The loads as the kernel shares them.
Vec4 share_evenly(const Problem& p) {
  const auto four = [](const Vec4& value) {
    kernel::Four<Batch> out;
    for (int i = 0; i < 4; ++i) out[static_cast<std::size_t>(i)] = Batch(value[i]);
    return out;
  };
  kernel::Four<Batch> z = four(p.z);
  kernel::share_evenly(Batch(1.0) > Batch(0.0), four(p.u), z);
  return first_lane(z);
}

/// The answer by trying all sets of loaded points: the one that is right in all signs.
Vec4 brute_force(const Problem& p) {
  for (unsigned set = 0; set < (1u << p.count); ++set) {
    Mat4 M = Mat4::Identity();
    Vec4 r = -p.z;
    for (int i = 0; i < p.count; ++i) {
      if (!(set >> i & 1u)) continue;
      M.row(i) = p.B.row(i);
      r[i] = -p.e[i];
    }
    const Vec4 d = M.fullPivLu().solve(r);
    const Vec4 velocity = p.e + p.B * d;
    bool right = true;
    for (int i = 0; i < p.count; ++i) {
      right = right && p.z[i] + d[i] >= -1e-9 && velocity[i] >= -1e-9;
    }
    if (right) return d;
  }
  FAIL("no set of loaded points is right");
  return Vec4::Zero();
}

}  // namespace

TEST_CASE("contact: the points of a manifold are solved as trying all sets does", "[pbd][lcp]") {
  std::mt19937 random(7);
  for (int count = 1; count <= 4; ++count) {
    for (int trial = 0; trial < 2000; ++trial) {
      const Problem p(random, count, 6);
      const Problem other(random, 1 + trial % 4, 6);
      const Vec4 expected = brute_force(p);
      const Vec4 d = solve(p, other);
      CAPTURE(count, trial);
      // The ridge makes a share of 1e-6 of the difference, times the condition of B.
      const double condition = p.B.topLeftCorner(count, count).inverse().norm() * p.B.norm();
      CHECK((d - expected).cwiseAbs().maxCoeff() <= 1e-5 * condition * (1.0 + p.z.maxCoeff()));
      // Other rows solved beside it have no effect.
      CHECK(solve(p, p) == d);
    }
  }
}

TEST_CASE("contact: of four points in a plane as many bear as need, as evenly as they can",
          "[pbd][lcp]") {
  std::mt19937 random(11);
  int even = 0;
  int let_go = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    Problem p(random, 4, 6);
    Eigen::Matrix<double, 4, 3> places;  // of the points: v = places * (up, two turns)
    for (int i = 0; i < 4; ++i) places.row(i) << 1.0, normal(random), normal(random);
    Eigen::Matrix3d root = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 9; ++i) root(i / 3, i % 3) += 0.3 * normal(random);
    p.B = places * (root * root.transpose()) * places.transpose();
    p.e = places * Eigen::Vector3d(normal(random), normal(random), normal(random));
    p.u = Eigen::FullPivLU<Eigen::Matrix<double, 3, 4>>(places.transpose()).kernel().col(0);
    p.u.normalize();
    const Problem other(random, 1 + trial % 4, 6);
    // Repeated, as sweeps repeat it.
    for (int sweep = 0; sweep < 60; ++sweep) {
      const Vec4 d = solve(p, p);
      CHECK(solve(p, other) == d);
      p.z += d;
      p.e += p.B * d;
    }
    CAPTURE(trial);
    const double load = p.z.norm() + 1.0;
    const double speed = p.B.norm() * load;
    CHECK(p.z.minCoeff() >= -1e-12 * load);
    CHECK(p.e.minCoeff() >= -1e-6 * speed);
    CHECK(p.z.cwiseProduct(p.e).maxCoeff() <= 1e-6 * speed * load);
    const Vec4 shared = share_evenly(p);
    CHECK((p.B * (shared - p.z)).norm() <= 1e-12 * speed);
    CHECK(shared.minCoeff() >= 0.0);
    if (p.z.minCoeff() > 0.0) {
      ++even;
      const bool settled = std::abs(p.u.dot(shared)) <= 1e-6 * load;
      CHECK((settled || shared.minCoeff() <= 1e-12 * load));
    } else {
      ++let_go;
      CHECK(shared == p.z);
    }
  }
  CHECK(even > 100);
  CHECK(let_go > 100);
}

TEST_CASE("contact: other rows do not change the sign of a zero", "[pbd][lcp]") {
  std::mt19937 random(5);
  const auto bits = [](const Vec4& d) {
    std::array<std::uint64_t, 4> out;
    for (std::size_t i = 0; i < 4; ++i) {
      out[i] = std::bit_cast<std::uint64_t>(d[static_cast<Eigen::Index>(i)]);
    }
    return out;
  };
  for (int trial = 0; trial < 500; ++trial) {
    Problem p(random, 4, 6);
    const Vec4 diagonal = p.B.diagonal();
    if (trial % 2 == 0) p.B = diagonal.asDiagonal();
    const Problem some(random, 2, 6);  // not all of its four points carry a load
    for (int i = 0; i < 4; ++i) {
      const auto draw = random();
      p.z[i] = (draw & 1u) != 0 ? 1.0 : 0.0;
      p.e[i] = (draw & 2u) != 0 ? 0.0 : -0.0;
      if (p.z[i] == 0.0) p.e[i] = (draw & 4u) != 0 ? -1e-320 : -1.0;
    }
    CAPTURE(trial);
    CHECK(bits(solve(p, p)) == bits(solve(p, some)));
  }
}

TEST_CASE("contact: points with an undetermined share of a load converge to a valid one",
          "[pbd][lcp]") {
  std::mt19937 random(11);
  for (int rank = 1; rank <= 3; ++rank) {
    for (int trial = 0; trial < 500; ++trial) {
      Problem p(random, 4, rank);
      // Velocities that some impulses can stop.
      p.e = p.B * Vec4(1.0, -2.0, 0.5, 0.3);
      const double fastest = p.e.cwiseAbs().maxCoeff();
      // After 30 one of 15000 draws is at 4e-6 still.
      for (int repeat = 0; repeat < 60; ++repeat) {
        const Vec4 d = solve(p, p);
        p.z += d;
        p.e += p.B * d;
      }
      CAPTURE(rank, trial);
      CHECK(p.z.minCoeff() >= 0.0);
      CHECK(p.e.minCoeff() >= -1e-6 * fastest);
      CHECK(p.z.cwiseProduct(p.e).cwiseAbs().maxCoeff() <= 1e-6 * fastest * p.z.maxCoeff());
    }
  }
}

}  // namespace contact_lcp_test
