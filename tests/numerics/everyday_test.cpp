// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A few cases of each group of benchmarks/everyday hold, but for the lines that its known.cpp
// names.
#include "everyday/group.h"
#include "support/catch.h"

namespace everyday_test {

using namespace tandem::everyday;

TEST_CASE("everyday: ordinary users' scenes behave", "[everyday]") {
  for (const Group& group : all_groups()) {
    if (!group.quick) continue;
    for (const Line& line : run_group(group, Extent::Quick)) {
      INFO(line.kind << ", " << line.name << ", " << line.ground << ": " << line.measure << " = "
                     << line.worst << " > " << line.bound << ' ' << line.unit << " at "
                     << line.worst_case);
      if (known_entry(line) < 0) CHECK(line.holds());
    }
  }
}

}  // namespace everyday_test
