// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The method by itself, in plain linear algebra: peers that each move by x' = M x in a frame, take
// the weighted mean of all states at their stamps, carry it to now by M, and close a share of the
// gap. docs/method.md proves what is checked here.
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "consensus/random.h"
#include "support/catch.h"

namespace tandem::consensus::linear_system_test {
namespace {

using testing::Dice;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double kDt = 1.0 / 60.0;  // s
constexpr int kLongest = 40;        // frames
constexpr int kMax = 20000;         // frames; what has agreed stays so

/// Undamped oscillators, coupled or not: what they do in a frame is exact, whatever their
/// frequency. A state is positions, then velocities.
class Oscillators {
 public:
  /// @param stiffness  1/s^2, symmetric and positive: x'' = -K x
  explicit Oscillators(const Matrix& stiffness) : stiffness_(stiffness) {
    const Eigen::Index n = stiffness.rows();
    const Eigen::SelfAdjointEigenSolver<Matrix> modes(stiffness);
    const Matrix& v = modes.eigenvectors();
    const Vector w = modes.eigenvalues().cwiseSqrt();
    const Vector c = (w * kDt).array().cos();
    const Vector s = (w * kDt).array().sin();
    Matrix m(2 * n, 2 * n);
    m.topLeftCorner(n, n) = v * c.asDiagonal() * v.transpose();
    m.bottomRightCorner(n, n) = m.topLeftCorner(n, n);
    m.topRightCorner(n, n) = v * s.cwiseQuotient(w).asDiagonal() * v.transpose();
    m.bottomLeftCorner(n, n) = -(v * s.cwiseProduct(w).asDiagonal() * v.transpose());
    powers_.push_back(Matrix::Identity(2 * n, 2 * n));
    for (int k = 0; k < kLongest; ++k) powers_.push_back(m * powers_.back());
  }
  static Oscillators single(double hertz) {
    const double w = 2.0 * std::numbers::pi * hertz;
    return Oscillators(Matrix::Constant(1, 1, w * w));
  }
  /// Three masses between walls and on springs of about that frequency.
  static Oscillators row(double hertz) {
    const double w = 2.0 * std::numbers::pi * hertz;
    Matrix k(3, 3);
    k << 2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 2.0;
    return Oscillators(w * w * k);
  }

  Eigen::Index size() const { return 2 * stiffness_.rows(); }
  Vector after(int frames, const Vector& x) const {
    return powers_[static_cast<std::size_t>(frames)] * x;
  }
  double energy(const Vector& x) const {
    const Eigen::Index n = stiffness_.rows();
    return 0.5 * (x.tail(n).squaredNorm() + x.head(n).dot(stiffness_ * x.head(n)));
  }
  /// The conserved quantity, as a length.
  double norm(const Vector& x) const { return std::sqrt(energy(x)); }

 private:
  Matrix stiffness_;
  std::vector<Matrix> powers_;
};

/// The newest state that one peer has of another.
struct News {
  std::size_t from = 0;
  int stamp = -1;       ///< frame; -1 = none
  double weight = 0.0;  ///< relative to the local state's 1
};

class Session {
 public:
  Session(const Oscillators& physics, std::size_t peers, double share, Dice& dice)
      : physics_(physics), share_(share), past_(peers) {
    for (auto& states : past_) {
      Vector x(physics.size());
      for (double& value : x) value = dice.uniform(-1.0, 1.0);
      states.push_back(x);
    }
  }

  const Vector& operator[](std::size_t peer) const { return past_[peer].back(); }
  int now() const { return static_cast<int>(past_[0].size()) - 1; }
  std::size_t peers() const { return past_.size(); }

  /// One frame of all peers. @param heard  what each of them has by now
  void step(const std::vector<std::vector<News>>& heard) {
    std::vector<Vector> next;
    for (std::size_t i = 0; i < peers(); ++i) {
      const Vector& own = (*this)[i];
      next.push_back(physics_.after(1, own + share_ * (target(i, heard[i]) - own)));
    }
    for (std::size_t i = 0; i < peers(); ++i) past_[i].push_back(next[i]);
  }

  double spread() const {
    double most = 0.0;
    for (std::size_t i = 1; i < peers(); ++i) {
      most = std::max(most, physics_.norm((*this)[i] - (*this)[0]));
    }
    return most;
  }
  double most_energy() const {
    double most = 0.0;
    for (std::size_t i = 0; i < peers(); ++i) most = std::max(most, physics_.energy((*this)[i]));
    return most;
  }

 private:
  /// One replay: from the local state at the oldest stamp on, each state is blended in as it is
  /// passed.
  Vector target(std::size_t peer, std::vector<News> news) const {
    std::erase_if(news, [](const News& n) { return n.stamp < 0; });
    if (news.empty()) return (*this)[peer];
    std::ranges::sort(news, {}, &News::stamp);
    int frame = news.front().stamp;
    Vector x = state(peer, frame);
    double total = 1.0;
    for (const News& n : news) {
      x = physics_.after(n.stamp - frame, x);
      frame = n.stamp;
      total += n.weight;
      x += n.weight / total * (state(n.from, frame) - x);
    }
    return physics_.after(now() - frame, x);
  }
  const Vector& state(std::size_t peer, int frame) const {
    return past_[peer][static_cast<std::size_t>(frame)];
  }

  const Oscillators& physics_;
  double share_;
  std::vector<std::vector<Vector>> past_;  ///< by peer and frame
};

const std::vector<Oscillators>& systems() {
  static const std::vector<Oscillators> all{Oscillators::single(0.2), Oscillators::single(3.0),
                                            Oscillators::single(29.0), Oscillators::row(2.0),
                                            Oscillators::row(14.0)};
  return all;
}

TEST_CASE("linear system: a difference contracts by 1 - s per frame at any delay",
          "[consensus][analytic]") {
  Dice dice(1);
  for (const Oscillators& physics : systems()) {
    for (int delay = 0; delay <= 30; ++delay) {
      for (const double share : {0.02, 0.08, 0.2, 0.5, 0.9, 1.0}) {
        CAPTURE(delay, share);
        Session session(physics, 2, share, dice);
        Vector alone = 0.5 * (session[0] + session[1]);  // the mean of two that do not agree
        Vector apart = session[0] - session[1];
        const double first = physics.norm(apart);
        double contraction = 0.0;
        double course = 0.0;
        for (int frame = 0; frame < 300; ++frame) {
          const int stamp = frame - delay;
          session.step({{{.from = 1, .stamp = stamp, .weight = 1.0}},
                        {{.from = 0, .stamp = stamp, .weight = 1.0}}});
          const double kept = stamp < 0 ? 1.0 : 1.0 - share;
          const Vector wanted = kept * physics.after(1, apart);
          apart = session[0] - session[1];
          contraction = std::max(contraction, physics.norm(apart - wanted) / first);
          alone = physics.after(1, alone);
          const Vector mean = 0.5 * (session[0] + session[1]);
          course = std::max(course, physics.norm(mean - alone) / physics.norm(alone));
        }
        CHECK(contraction < 1e-9);
        CHECK(course < 1e-9);
      }
    }
  }
}

TEST_CASE("linear system: a mean that left its course comes to one that needs no agreement",
          "[consensus][analytic]") {
  // In the frame that moves along: y' = (1 - s) y + s y[d frames ago]. One root of z^(d + 1) = (1 -
  // s) z^d + s is 1, and all others are inside the unit circle: where one push has parted the mean
  // from its own past, that dies out.
  for (int delay = 1; delay <= 30; ++delay) {
    for (const double share : {0.02, 0.2, 0.5, 0.9}) {
      CAPTURE(delay, share);
      Matrix companion = Matrix::Zero(delay + 1, delay + 1);
      companion(0, 0) = 1.0 - share;
      companion(0, delay) += share;
      for (int i = 0; i < delay; ++i) companion(i + 1, i) = 1.0;
      const Eigen::VectorXcd roots = companion.eigenvalues();
      int ones = 0;
      double largest = 0.0;
      for (const std::complex<double>& root : roots) {
        if (std::abs(root - 1.0) < 1e-9) {
          ++ones;
        } else {
          largest = std::max(largest, std::abs(root));
        }
      }
      CHECK(ones == 1);
      CHECK(largest < 1.0 - 1e-5);
    }
  }
}

/// The states that each peer hears, their ages and weights.
struct Network {
  int shortest = 0;  ///< frames
  int longest = 30;
  double loss = 0.2;
  bool alike = false;  ///< equal weights
};

struct Way {
  int base = 0;  ///< frames
  int jitter = 0;
  double weight = 1.0;                    ///< of the sender's states at the receiver
  int stamp = -1;                         ///< of the newest state that has come
  std::vector<std::pair<int, int>> sent;  ///< (arrives, stamp)
};

struct Outcome {
  double spread = 0.0;  ///< of the beginning
  double energy = 0.0;  ///< largest ever, of the largest of the beginning
};

Outcome agree(const Oscillators& physics, std::size_t peers, double share, const Network& network,
              Dice& dice) {
  Session session(physics, peers, share, dice);
  std::vector<std::vector<Way>> ways(peers, std::vector<Way>(peers));
  for (std::size_t to = 0; to < peers; ++to) {
    for (std::size_t from = 0; from < peers; ++from) {
      Way& way = ways[to][from];
      way.base = network.shortest + static_cast<int>(dice.below(static_cast<std::size_t>(
                                        network.longest - network.shortest + 1)));
      way.jitter =
          static_cast<int>(dice.below(static_cast<std::size_t>(network.longest - way.base + 1)));
      way.weight = network.alike ? 1.0 : dice.uniform(0.1, 2.0);
    }
  }
  const double spread = session.spread();
  const double energy = session.most_energy();
  Outcome outcome;
  std::vector<std::vector<News>> heard(peers);
  for (int frame = 0; frame < kMax && session.spread() > 1e-10 * spread; ++frame) {
    for (std::size_t to = 0; to < peers; ++to) {
      heard[to].clear();
      for (std::size_t from = 0; from < peers; ++from) {
        if (to == from) continue;
        Way& way = ways[to][from];
        if (dice.uniform(0.0, 1.0) >= network.loss) {
          const int late =
              way.base + static_cast<int>(dice.below(static_cast<std::size_t>(way.jitter + 1)));
          way.sent.emplace_back(frame + late, frame);
        }
        std::erase_if(way.sent, [&](const std::pair<int, int>& packet) {
          if (packet.first > frame) return false;
          way.stamp = std::max(way.stamp, packet.second);
          return true;
        });
        // States older than the oldest one in use have expired.
        if (frame - way.stamp >= kLongest) continue;
        heard[to].push_back({.from = from, .stamp = way.stamp, .weight = way.weight});
      }
    }
    session.step(heard);
    outcome.energy = std::max(outcome.energy, session.most_energy() / energy);
  }
  outcome.spread = session.spread() / spread;
  return outcome;
}

TEST_CASE("linear system: any peers agree over any ways, and no energy comes from it",
          "[consensus][analytic]") {
  Dice dice(2);
  for (std::size_t peers = 2; peers <= 8; ++peers) {
    for (const double share : {0.02, 0.1, 0.3, 0.6, 0.9}) {
      for (const bool alike : {true, false}) {
        for (std::size_t k = 0; k < systems().size(); ++k) {
          CAPTURE(peers, share, alike, k);
          const Outcome outcome = agree(systems()[k], peers, share, {.alike = alike}, dice);
          CHECK(outcome.spread < 1e-9);
          CHECK(outcome.energy < 1.0 + 1e-9);
        }
      }
    }
  }
}

TEST_CASE("linear system: ways of very unequal length agree as well", "[consensus][analytic]") {
  Dice dice(3);
  const Oscillators physics = Oscillators::row(3.0);
  for (int there = 0; there <= 30; there += 2) {
    for (int back = there; back <= 30; back += 7) {
      // All of the gap at once would keep nothing of the present: worlds that are steps apart in
      // time would come together by ever less.
      for (const double share : {0.1, 0.3, 0.6}) {
        CAPTURE(there, back, share);
        Session session(physics, 2, share, dice);
        const double spread = session.spread();
        const double energy = session.most_energy();
        double most = 0.0;
        for (int frame = 0; frame < kMax && session.spread() > 1e-10 * spread; ++frame) {
          session.step({{{.from = 1, .stamp = frame - back, .weight = 1.0}},
                        {{.from = 0, .stamp = frame - there, .weight = 1.0}}});
          most = std::max(most, session.most_energy());
        }
        CHECK(session.spread() < 1e-9 * spread);
        CHECK(most < energy * (1.0 + 1e-9));
      }
    }
  }
}

}  // namespace
}  // namespace tandem::consensus::linear_system_test
