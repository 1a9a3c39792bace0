// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_convergence.h"

#include <numeric>

#include "support/catch.h"

namespace contact_convergence_test {

using namespace tandem::pbd;

namespace {

/// Balls of 1 kg in a row along x; row k holds ball k + 1 off ball k, body 0 does not move. Where
/// the last ball comes in at 1 m/s, all impulses have to be 1 N s, and as many sweeps as balls do
/// not make them so: each gives half of the blow to the next one.
struct Train {
  std::vector<SolverBody> bodies;
  std::vector<ContactRows> rows;
  ContactConvergence convergence;
  ContactOrder order;
  Workers workers;
  const ContactKernels& kernels = contact_kernels(0);

  explicit Train(std::uint32_t balls) : bodies(balls + 1), rows(balls) {
    for (std::uint32_t i = 1; i <= balls; ++i) {
      bodies[i].inv_mass = 1.0;
      bodies[i].group = 0;
    }
    std::vector<ContactLink> links;
    for (std::uint32_t k = 0; k < balls; ++k) {
      links.push_back({.contact = k, .a = k, .b = k + 1, .moves_a = k > 0, .moves_b = true});
      rows[k].a.fill(k);
      rows[k].b.fill(k + 1);
      rows[k].a_moves = k > 0 ? 1 : 0;
      rows[k].b_moves = 1;
      rows[k].count = 1;
      rows[k].normal[0].fill(1.0);
      rows[k].t1[1].fill(1.0);
      rows[k].k_nn.fill(k > 0 ? 2.0 : 1.0);
    }
    std::vector<std::uint32_t> movers(bodies.size());
    std::iota(movers.begin(), movers.end(), 0u);
    order.build(links, ContactCells(), bodies.size(), movers, 1);
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(rows.size()); }
  void sweep() {
    for (std::uint32_t k = 0; k < count(); ++k) {
      kernels.solve(rows[k], ContactPass::Motion, normal_friction_iterations(false), kAllLanes,
                    numbers_of(bodies));
    }
  }
  ContactConvergence::Outcome run(double tolerance, int most, int sweeps = 1'000'000) {
    return convergence.run({.tolerance = tolerance, .rows = most, .sweeps = sweeps}, order, 0,
                           false, rows, kernels, bodies, workers);
  }
};

}  // namespace

TEST_CASE("convergence: a blow on a train of balls arrives at the wall", "[contact][analytic]") {
  Train train(10);
  train.bodies[10].v = Vec3(-1.0, 0.0, 0.0);
  train.sweep();
  const auto [swept, open] = train.run(1e-6, 1'000'000);
  CHECK(open == 0);
  CHECK(swept > 100);
  for (const ContactRows& row : train.rows) {
    CHECK(row.impulse[0][0] == Approx(1.0).margin(1e-4));
  }
  for (const SolverBody& body : train.bodies) CHECK(std::abs(body.v.x()) < 1e-4);
}

TEST_CASE("convergence: solved and undisturbed rows are not swept", "[contact]") {
  Train still(5);
  still.sweep();
  CHECK(still.run(1e-6, 1000).swept == 0);
  // The blow is between the first two of them: the last rows hear of it later or never.
  Train train(100);
  train.bodies[2].v = Vec3(-1.0, 0.0, 0.0);
  train.sweep();
  const auto [swept, open] = train.run(0.3, 1'000'000);
  CHECK(open == 0);
  CHECK(swept > 0);
  CHECK(swept < 20);
}

TEST_CASE("convergence: the budget is kept, goes to the hardest blow and reports the rest",
          "[contact]") {
  Train train(40);
  train.bodies[10].v = Vec3(-0.01, 0.0, 0.0);
  train.bodies[30].v = Vec3(-10.0, 0.0, 0.0);
  train.sweep();
  const double soft = train.rows[9].impulse[0][0];
  const double hard = train.rows[29].impulse[0][0];
  for (const int most : {4, 8}) {
    const auto [swept, open] = train.run(1e-6, most);
    CHECK(swept <= most);
    CHECK(swept > 0);
    CHECK(open > 0);
  }
  CHECK(train.rows[9].impulse[0][0] == soft);
  CHECK(train.rows[29].impulse[0][0] > hard);
  CHECK(train.run(1e-6, 0).swept == 0);
  const auto [swept, open] = train.run(1e-6, 1'000'000, 3);
  CHECK(swept > 0);
  CHECK(swept <= 3 * static_cast<int>(train.count()));
  CHECK(open > 0);
}

}  // namespace contact_convergence_test
