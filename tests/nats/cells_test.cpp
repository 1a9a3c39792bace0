// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/nats/cells.h"

#include <set>
#include <string>

#include "subjects.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::nats::cells_test {
namespace {

using pbd::Vec3;

TEST_CASE("cells: a cell of each level lies in the one above, on both sides of zero", "[nats]") {
  const CellOptions options{.edge = 2.0, .levels = 4};
  for (double x = -70.0; x < 70.0; x += 0.37) {
    const Vec3 at(x, -0.7 * x + 1.3, 5.0);
    for (int level = 0; level + 1 < options.levels; ++level) {
      const Cell cell = cell_at(options, at, level);
      CHECK(parent_of(cell) == cell_at(options, at, level + 1));
      CHECK(distance_to(options, cell, at) == 0.0);
    }
  }
  CHECK(distance_to(options, {0, 0, 0}, Vec3(-1.0, 5.0, 0.0)) == Approx(3.0));
}

TEST_CASE("subjects: that of a cell begins with those of all that it lies in", "[nats]") {
  const CellOptions options{.edge = 2.0, .levels = 3};
  const Subjects subjects("t", 0xabc, options);
  const Vec3 at(-3.0, 41.0, 0.0);
  const std::string whole = subjects.path(cell_at(options, at, 2));
  CHECK(whole == "-1_1");
  const std::string part = subjects.path(cell_at(options, at, 1));
  CHECK(part == whole + ".7");
  CHECK(subjects.path(cell_at(options, at, 0)) == part + ".2");
  CHECK(subjects.who(cell_at(options, at)) == "t.0000000000000abc.who." + part + ".2");
  // No two cells have the same name.
  std::set<std::string> all;
  for (int x = -20; x < 20; ++x) {
    for (int y = -20; y < 20; ++y) CHECK(all.insert(subjects.path({0, x, y})).second);
  }
}

}  // namespace
}  // namespace tandem::nats::cells_test
