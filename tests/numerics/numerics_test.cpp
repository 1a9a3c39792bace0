// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Every bound of the numerics set holds, but for those that benchmarks/numerics/known.cpp names.
#include <algorithm>

#include "numerics/case.h"
#include "support/catch.h"

namespace numerics_test {

using namespace tandem::bench;

namespace {

void check_family(const std::string& family) {
  for (const Case& c : all_cases()) {
    if (c.family != family) continue;
    const Outcome outcome = run_case(c, make_tandem);
    INFO(c.name);
    const bool built = outcome.not_built.empty();
    if (known_failure(c.name, "").empty()) CHECK(built);
    int known = 0;
    int known_failing = 0;
    for (const Check& check : outcome.checks) {
      INFO(check.measure << " = " << check.value << ", reference " << check.reference << " ("
                         << check.source << "), error " << check.error << " > " << check.bound
                         << ' ' << check.unit);
      if (known_failure(c.name, check.measure).empty()) {
        CHECK(check.holds());
      } else {
        ++known;
        known_failing += check.holds() ? 0 : 1;
      }
    }
    if (known > 0 && known_failing == 0) WARN(c.name << ": holds now, take it off the list");
  }
}

}  // namespace

TEST_CASE("numerics: motions that have a closed form", "[numerics][analytic]") {
  check_family("analytic");
}

TEST_CASE("numerics: stiff scenes hold", "[numerics][stiff]") { check_family("stiff"); }

TEST_CASE("numerics: extreme scenes stay bounded", "[numerics][extreme]") {
  check_family("extreme");
}

TEST_CASE("numerics: the list of exceptions names cases that exist", "[numerics]") {
  const std::vector<Case> cases = all_cases();
  for (const std::string_view name : known_cases()) {
    INFO(name);
    CHECK(std::any_of(cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; }));
  }
}

}  // namespace numerics_test
