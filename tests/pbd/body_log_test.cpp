// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/body_log.h"

#include <algorithm>
#include <set>
#include <vector>

#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace body_log_test {

using tandem::pbd::BodyLog;

namespace {

/// A log's extra entries: bodies that move, and changes since a mark.
struct Model {
  std::vector<std::uint8_t> moves;
  std::set<std::uint32_t> changed;

  std::vector<std::uint32_t> movers() const {
    std::vector<std::uint32_t> slots;
    for (std::uint32_t i = 0; i < moves.size(); ++i) {
      if (moves[i] != 0) slots.push_back(i);
    }
    return slots;
  }
};

std::set<std::uint32_t> read(const BodyLog& log, BodyLog::Mark& mark, bool& known) {
  std::set<std::uint32_t> slots;
  known = log.read(mark, [&](std::uint32_t slot) { slots.insert(slot); });
  return slots;
}

TEST_CASE("A log lists bodies that may move, ascending, while bodies come and go", "[body_log]") {
  tandem::pbd::SplitMix64 random(7);
  BodyLog log;
  BodyLog::Mark mark;
  Model model;
  bool known = false;
  read(log, mark, known);
  CHECK_FALSE(known);
  for (int step = 0; step < 200; ++step) {
    const std::uint64_t changes = random.below(8);
    for (std::uint64_t k = 0; k < changes; ++k) {
      const bool is_new = model.moves.empty() || random.below(4) == 0;
      if (is_new) model.moves.push_back(0);
      const std::uint64_t any = random.below(model.moves.size());
      const auto slot = static_cast<std::uint32_t>(is_new ? model.moves.size() - 1 : any);
      model.moves[slot] = random.below(2) == 0 ? 0 : 1;
      log.note(slot, model.moves.size());
      model.changed.insert(slot);
    }
    const auto movers =
        log.movers(model.moves.size(), [&](std::uint32_t slot) { return model.moves[slot] != 0; });
    REQUIRE(std::vector<std::uint32_t>(movers.begin(), movers.end()) == model.movers());
    const std::set<std::uint32_t> told = read(log, mark, known);
    if (step > 0) {
      REQUIRE(known);
      REQUIRE(told == model.changed);
      CHECK(log.is_quiet(mark));
    }
    model.changed.clear();
    log.end_step();
  }
}

TEST_CASE("A reader that misses two steps of a log looks at everything", "[body_log]") {
  BodyLog log;
  BodyLog::Mark often;
  BodyLog::Mark seldom;
  bool known = false;
  log.note(0, 4);
  read(log, often, known);
  read(log, seldom, known);
  for (std::uint32_t i = 1; i < 4; ++i) {
    log.note(i, 4);
    CHECK(read(log, often, known) == std::set<std::uint32_t>{i});
    CHECK(known);
    log.end_step();
  }
  read(log, seldom, known);
  CHECK_FALSE(known);
  log.note(2, 4);
  CHECK(read(log, seldom, known) == std::set<std::uint32_t>{2});
  CHECK(known);
}

TEST_CASE("A mark of one log says nothing of another one", "[body_log]") {
  BodyLog log;
  BodyLog other;
  BodyLog::Mark mark;
  bool known = false;
  log.note(0, 4);
  other.note(1, 4);
  read(log, mark, known);
  CHECK_FALSE(other.is_quiet(mark));
  read(other, mark, known);
  CHECK_FALSE(known);
  log = std::move(other);
  read(log, mark, known);
  CHECK(known);
  other.note(3, 4);
  CHECK_FALSE(other.is_quiet(mark));
  read(other, mark, known);
  CHECK_FALSE(known);
}

TEST_CASE("A log of a world that nobody steps stays bounded", "[body_log]") {
  BodyLog log;
  BodyLog::Mark mark;
  bool known = false;
  log.note(0, 4);
  read(log, mark, known);
  for (int i = 0; i < 10000; ++i) log.note(1, 4);
  int told = 0;
  log.read(mark, [&](std::uint32_t) { ++told; });
  CHECK(told <= 2048);
}

}  // namespace
}  // namespace body_log_test
