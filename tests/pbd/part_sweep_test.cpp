// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sweeps that workers share. Data that they share here is plain on purpose: under the thread
// sanitizer no two of them touch the same thing at once.
#include "part_sweep.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "contact_order.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace part_sweep_test {

using namespace tandem::pbd;

namespace {

/// Blocks of one row each, between two of `kBodies` bodies in a row, in parts by the first of them.
struct Rows {
  static constexpr std::uint32_t kBodies = 120;
  struct Row {
    std::uint32_t a, b, part;
  };
  std::vector<Row> in_order;
  std::vector<std::uint32_t> at;  ///< by block: which of them it is
  PartSweep sweep;

  Rows(std::uint32_t parts, std::uint32_t count, std::uint64_t seed) {
    SplitMix64 random(seed);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto a = static_cast<std::uint32_t>(random.below(kBodies - 6));
      const auto b = a + 1 + static_cast<std::uint32_t>(random.below(5));
      in_order.push_back({a, b, a * parts / kBodies});
    }
    std::vector<std::uint32_t> begins(parts + 1, 0);
    for (const Row& row : in_order) ++begins[row.part + 1];
    for (std::uint32_t p = 0; p < parts; ++p) begins[p + 1] += begins[p];
    sweep.start(begins);
    at.resize(count);
    std::vector<std::uint32_t> last(kBodies, count);
    for (std::uint32_t i = 0; i < count; ++i) {
      const Row& row = in_order[i];
      const std::uint32_t block = begins[row.part]++;
      at[block] = i;
      for (const std::uint32_t body : {row.a, row.b}) {
        const std::uint32_t before = last[body];
        const std::uint32_t part = before < count ? in_order[at[before]].part : row.part;
        if (part != row.part) sweep.link(before, part, block, row.part);
        last[body] = block;
      }
    }
  }

  /// The result depends on the order of any two rows that share a body.
  void act(std::uint32_t i, std::vector<std::uint64_t>& numbers) const {
    const Row& row = in_order[i];
    const std::uint64_t mixed = 6364136223846793005u * (numbers[row.a] ^ (numbers[row.b] << 1)) + i;
    numbers[row.a] = mixed ^ (mixed >> 29);
    numbers[row.b] += 3 * mixed + 1;
  }
  std::vector<std::uint64_t> in_turn(bool reverse) const {
    std::vector<std::uint64_t> numbers(kBodies, 1);
    const auto count = static_cast<std::uint32_t>(in_order.size());
    for (std::uint32_t i = 0; i < count; ++i) act(reverse ? count - 1 - i : i, numbers);
    return numbers;
  }
};

}  // namespace

TEST_CASE("part sweep: rows that share a body are visited in the order of one thread",
          "[pbd][unit]") {
  for (const int count : {1, 2, 3, 8}) {
    Workers workers(count);
    for (const std::uint32_t parts : {2u, 3u, 7u, 64u}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        Rows rows(parts, 1500, seed);
        for (const bool reverse : {false, true}) {
          std::vector<std::uint64_t> numbers(Rows::kBodies, 1);
          rows.sweep.run(reverse, workers,
                         [&](std::uint32_t block) { rows.act(rows.at[block], numbers); });
          CAPTURE(count, parts, seed, reverse);
          CHECK(numbers == rows.in_turn(reverse));
        }
      }
    }
  }
}

TEST_CASE("part sweep: the number of workers does not change the blocks", "[pbd][unit]") {
  // Columns of bricks, each brick beside one of the next column or of the one before.
  constexpr std::uint32_t kWide = 150;
  constexpr std::uint32_t kHigh = 20;
  std::vector<SolverBody> bodies(1 + kWide * kHigh);
  std::vector<std::uint32_t> movers;
  std::vector<ContactLink> links;
  const auto brick = [](std::uint32_t i, std::uint32_t row) { return 1 + row * kWide + i; };
  const auto touch = [&](std::uint32_t a, std::uint32_t b) {
    links.push_back({.contact = static_cast<std::uint32_t>(links.size()),
                     .a = a,
                     .b = b,
                     .moves_a = a > 0,
                     .moves_b = true,
                     .face = a % 3 > 0});
  };
  for (std::uint32_t row = 0; row < kHigh; ++row) {
    for (std::uint32_t i = 0; i < kWide; ++i) {
      SolverBody& body = bodies[brick(i, row)];
      body.inv_mass = 1.0;
      body.group = 0;
      body.x = Vec3(i, 0.0, row);
      movers.push_back(brick(i, row));
      touch(row == 0 ? 0 : brick(i, row - 1), brick(i, row));
      if (i > 0 && (i + row) % 2 == 0) touch(brick(i - 1, row), brick(i, row));
    }
  }
  const std::vector<GroupFacts> groups{{.substeps = 4, .one_island = true}};
  ContactCells cells;
  cells.find(
      links,
      {.bodies = bodies, .movers = movers, .gravity = Vec3(0.0, 0.0, -9.81), .groups = groups});
  CHECK(cells.contacts(0) == links.size());
  ContactOrder one;
  one.build(links, cells, bodies.size(), movers, 1);
  CHECK(one.by_level(0).empty());
  CHECK(one.row_count(0) == static_cast<int>(links.size()));
  for (const std::uint32_t count : {2u, 3u, 8u}) {
    ContactOrder order;
    order.build(links, cells, bodies.size(), movers, count);
    CAPTURE(count);
    REQUIRE(order.by_level(0).size() == one.places(0).size() / kLanes);
    std::vector<std::uint32_t> places;
    for (const std::uint32_t block : order.by_level(0)) {
      const auto lanes = order.places(0).subspan(block * kLanes, kLanes);
      places.insert(places.end(), lanes.begin(), lanes.end());
    }
    CHECK(std::ranges::equal(places, one.places(0)));
    // Each row after those before it that share a brick, and back.
    Workers workers(static_cast<int>(count));
    for (const bool reverse : {false, true}) {
      std::vector<std::vector<std::uint32_t>> expected(bodies.size());
      std::vector<std::vector<std::uint32_t>> visited(bodies.size());
      const auto visit = [&](std::uint32_t contact, auto& lists) {
        for (const std::uint32_t body : {links[contact].a, links[contact].b}) {
          if (body > 0) lists[body].push_back(contact);
        }
      };
      for (const ContactLink& link : links) visit(link.contact, expected);
      if (reverse) {
        for (auto& list : expected) std::ranges::reverse(list);
      }
      order.sweep(0, reverse, workers, [&](std::uint32_t block) {
        for (const std::uint32_t contact : order.places(0).subspan(block * kLanes, kLanes)) {
          if (contact != ContactOrder::kNone) visit(contact, visited);
        }
      });
      CHECK(visited == expected);
    }
  }
}

}  // namespace part_sweep_test
