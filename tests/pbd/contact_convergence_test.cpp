// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_convergence.h"

#include "support/catch.h"
#include "tandem/pbd/bytes.h"

namespace contact_convergence_test {

using namespace tandem::pbd;

namespace {

constexpr int kSweeps = 8;

/// An island that no sweep solves: its rows push a body that does not answer.
struct Stubborn {
  std::vector<SolverBody> bodies{2};
  std::vector<ContactRow> rows;
  std::vector<double> changes;
  ContactConvergence convergence;

  explicit Stubborn(std::uint32_t count) : rows(count), changes(count) {
    bodies[1].group = 0;
    bodies[1].island = 1;
    bodies[1].v = Vec3(-0.1, 0.0, 0.0);
    for (ContactRow& row : rows) {
      row.b = 1;
      row.count = 1;
      row.press_n = 1.0;
    }
  }
  /// Rows swept again in a step of one substep.
  /// @param change  m/s, of each row in the first sweep
  int step(double change) {
    const auto count = static_cast<std::uint32_t>(rows.size());
    convergence.begin_step(bodies, {}, rows);
    changes.assign(count, change);
    const ContactConvergence::Rule rule{.sweeps = kSweeps, .resting = 1e-3, .fresh = false};
    const int swept = convergence.run(rule, {0, count}, false, rows, changes, bodies);
    convergence.end_step(bodies);
    return swept;
  }
};

}  // namespace

TEST_CASE("a large island that stays unsolved for half a second is given up until one sweep does",
          "[contact]") {
  Stubborn island(101);
  for (int i = 0; i < 30; ++i) CHECK(island.step(0.1) == kSweeps * 101);
  for (int i = 0; i < 100; ++i) CHECK(island.step(0.1) == 0);
  CHECK_FALSE(island.convergence.was_hard(1));
  CHECK(island.convergence.unrest(1) == 0.0);
  // It was unsolved for long: one good step is not enough, some are.
  CHECK(island.step(0.0) == 0);
  CHECK(island.step(0.1) == 0);
  for (int i = 0; i < 11; ++i) CHECK(island.step(0.0) == 0);
  CHECK(island.step(0.1) == kSweeps * 101);
}

TEST_CASE("a small island is never given up", "[contact]") {
  Stubborn island(100);
  for (int i = 0; i < 200; ++i) CHECK(island.step(0.1) == kSweeps * 100);
}

TEST_CASE("a snapshot knows how long an island was unsolved", "[contact][snapshot]") {
  Stubborn island(101);
  for (int i = 0; i < 29; ++i) island.step(0.1);
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  island.convergence.save(out);
  Stubborn other(101);
  ByteReader in(bytes);
  other.convergence.load(in);
  REQUIRE_FALSE(in.failed());
  CHECK(other.step(0.1) == kSweeps * 101);
  CHECK(other.step(0.1) == 0);
}

}  // namespace contact_convergence_test
