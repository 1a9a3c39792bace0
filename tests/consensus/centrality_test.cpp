// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Internal: what a vote counts beside others.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "../../consensus/src/agree/votes.h"
#include "consensus/random.h"
#include "support/catch.h"

namespace tandem::consensus::centrality_test {
namespace {

using testing::Dice;

StateOffset at(double x, double y = 0.0) { return {x, y}; }

double apart(const StateOffset& a, const StateOffset& b) {
  double square = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(square);
}

StateOffset random_in_ball(Dice& dice, double radius) {
  StateOffset v{};
  double square = 0.0;
  for (double& component : v) {
    component = dice.uniform(-1.0, 1.0);
    square += component * component;
  }
  const double length = dice.uniform(0.0, radius);
  for (double& component : v) component *= length / std::sqrt(square);
  return v;
}

TEST_CASE("centrality: votes in one place count in full, and one elsewhere nothing",
          "[consensus]") {
  for (const std::size_t count : {3u, 4u, 9u}) {
    for (const double far : {1e-9, 1.0, 1e7}) {
      std::vector<Vote> votes(count, Vote{.at = at(2.0), .weight = 1.0});
      votes[1].at = at(2.0, far);
      weigh_centrality(votes);
      for (std::size_t i = 0; i < count; ++i) CHECK(votes[i].central == (i == 1 ? 0.0 : 1.0));
    }
  }
  std::array<Vote, 3> same{Vote{at(1.0), 1.0}, Vote{at(1.0), 1.0}, Vote{at(1.0), 1.0}};
  weigh_centrality(same);
  for (const Vote& vote : same) CHECK(vote.central == 1.0);
}

TEST_CASE("centrality: of two clusters of one weight, and of votes all apart, all count",
          "[consensus]") {
  std::array<Vote, 4> two{Vote{at(0.0), 1.0}, Vote{at(0.0), 1.0}, Vote{at(3.0), 1.0},
                          Vote{at(3.0), 1.0}};
  weigh_centrality(two);
  for (const Vote& vote : two) CHECK(vote.central == 1.0);
  const double h = std::sqrt(0.75);
  std::array<Vote, 3> three{Vote{at(0.0), 1.0}, Vote{at(1.0), 1.0}, Vote{at(0.5, h), 1.0}};
  weigh_centrality(three);
  for (const Vote& vote : three) CHECK(vote.central == Approx(1.0));
}

TEST_CASE("centrality: a vote beyond the stated distance counts nothing", "[consensus]") {
  Dice dice(11);
  for (int trial = 0; trial < 2000; ++trial) {
    const std::size_t count = 3 + dice.below(6);
    const double a = 1.0 / static_cast<double>(count);
    const double p = periphery(count).none;
    const double reach = (1.0 - a + p * (2.0 - a)) / (1.0 - a - p * a);
    std::vector<Vote> votes(count);
    for (Vote& vote : votes) vote = {.at = random_in_ball(dice, 1.0), .weight = 1.0};
    const StateOffset way = random_in_ball(dice, 1.0);
    const double length = apart(way, {});
    for (std::size_t k = 0; k < way.size(); ++k) votes[0].at[k] = way[k] / length * reach * 1.001;
    weigh_centrality(votes);
    CHECK(votes[0].central == 0.0);
  }
}

/// Peers that do nothing but agree, as fuse() does with what centrality leaves, and one that says
/// the worst of many things to each of them. @return how far their centre went
double drift(std::size_t honest, bool same_to_all, Dice& dice, double& spread) {
  std::vector<StateOffset> x(honest);
  for (StateOffset& state : x) state = random_in_ball(dice, 1.0);
  const auto centre = [&](const std::vector<StateOffset>& of) {
    StateOffset mean{};
    for (const StateOffset& state : of) {
      for (std::size_t k = 0; k < mean.size(); ++k)
        mean[k] += state[k] / static_cast<double>(honest);
    }
    return mean;
  };
  const StateOffset start = centre(x);
  const StateOffset aim = random_in_ball(dice, 1.0);
  const double length = apart(aim, {});
  constexpr double kShare = 0.08;
  for (int step = 0; step < 400; ++step) {
    double radius = 0.0;
    for (const StateOffset& state : x) radius = std::max(radius, apart(state, centre(x)));
    std::vector<StateOffset> next = x;
    for (std::size_t i = 0; i < honest; ++i) {
      double best = -1.0;
      for (int attempt = 0; attempt < 24; ++attempt) {
        // Along the aim, or away from the others, at all distances that might count.
        const double reach = radius * 0.5 * attempt;
        std::vector<Vote> votes(honest + 1, Vote{.weight = 1.0});
        for (std::size_t j = 0; j < honest; ++j) votes[j].at = x[j];
        const StateOffset from = centre(x);
        const double own = apart(x[i], from);
        for (std::size_t k = 0; k < aim.size(); ++k) {
          const double out = own > 0.0 ? (x[i][k] - from[k]) / own : 0.0;
          votes[honest].at[k] = from[k] + reach * (same_to_all ? aim[k] / length : out);
        }
        weigh_centrality(votes);
        StateOffset moved = x[i];
        double total = 0.0;
        StateOffset sum{};
        for (std::size_t j = 0; j <= honest; ++j) {
          if (j == i) continue;
          const double w = kShare / (1.0 - kShare) * votes[j].central;
          total += w;
          for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += w * (votes[j].at[k] - x[i][k]);
        }
        for (std::size_t k = 0; k < sum.size(); ++k) moved[k] += sum[k] / (1.0 + total);
        double gain = 0.0;
        for (std::size_t k = 0; k < aim.size(); ++k) {
          gain += same_to_all ? (moved[k] - x[i][k]) * aim[k] : 0.0;
        }
        if (!same_to_all) gain = apart(moved, from);
        if (attempt > 0 && gain <= best) continue;
        best = gain;
        next[i] = moved;
      }
    }
    x = next;
  }
  spread = 0.0;
  for (const StateOffset& state : x) spread = std::max(spread, apart(state, centre(x)));
  return apart(centre(x), start);
}

TEST_CASE("centrality: the worst state of one peer does not move others that agree far",
          "[consensus]") {
  Dice dice(13);
  for (const std::size_t honest : {2u, 3u, 5u}) {
    for (int trial = 0; trial < 10; ++trial) {
      double spread = 0.0;
      // Radii of the honest states at the start, which are within 1 of each other's centre.
      const double by = drift(honest, true, dice, spread);
      INFO(honest << " honest: " << by << " and " << spread << " apart");
      CHECK(by < 3.0);
      CHECK(spread < 0.05);
      if (honest < 3) continue;
      const double split = drift(honest, false, dice, spread);
      INFO("to each something else: " << split << " and " << spread << " apart");
      CHECK(split < 3.0);
      CHECK(spread < 1.0);
    }
  }
}

TEST_CASE("majority: the fewer give way, of as many those without the lowest id", "[consensus]") {
  const auto claim = [](PeerId peer, double x) {
    return Claim{.peer = peer, .way = pbd::Vec3(x, 0.0, 0.0)};
  };
  const std::array<Claim, 1> two{claim(3, 1.0)};
  CHECK(outvoted(two, 0, 4));
  CHECK_FALSE(outvoted(two, 0, 2));
  // The lowest id against all others.
  const std::array<Claim, 3> four{claim(1, 1.0), claim(3, 0.01), claim(4, -0.01)};
  CHECK_FALSE(outvoted(four, 0, 2));
  const std::array<Claim, 3> liar{claim(2, 1.0), claim(3, 1.01), claim(4, 0.99)};
  CHECK(outvoted(liar, 0, 1));
  // Two and two: those with peer 1, seen from either side.
  const std::array<Claim, 3> with{claim(2, 1.0), claim(3, 0.0), claim(4, 1.0)};
  CHECK_FALSE(outvoted(with, 0, 1));
  CHECK_FALSE(outvoted(with, 2, 1));
  const std::array<Claim, 3> against{claim(1, 1.0), claim(2, 0.0), claim(3, 1.0)};
  CHECK(outvoted(against, 0, 4));
  CHECK(outvoted(against, 2, 4));
}

}  // namespace
}  // namespace tandem::consensus::centrality_test
