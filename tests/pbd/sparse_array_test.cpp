// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/sparse_array.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <utility>

#include "support/catch.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/props_table.h"

using namespace tandem::pbd;
using tandem::pbd::detail::SparseArray;

TEST_CASE("sparse array: new elements are zero, written ones stay", "[pbd][unit]") {
  SparseArray<std::uint32_t> array;
  const auto zero = [](std::uint32_t value) { return value == 0; };
  array.resize(3000);
  CHECK(std::all_of(array.begin(), array.end(), zero));
  array[2999] = 7;
  array.resize(100000);
  CHECK(array[2999] == 7);
  CHECK(std::all_of(array.begin() + 3000, array.end(), zero));
  array[5000] = 8;
  array.resize(10);
  array.resize(6000);
  CHECK(std::all_of(array.begin(), array.end(), zero));

  array[20] = 9;
  SparseArray<std::uint32_t> copy = array;
  array[20] = 10;
  CHECK(copy.size() == 6000);
  CHECK(copy[20] == 9);
  copy.resize(10);
  copy = std::as_const(array);
  CHECK(copy[20] == 10);
  const SparseArray<std::uint32_t> moved = std::move(copy);
  CHECK(moved[20] == 10);
}

TEST_CASE("sparse array: unwritten elements take no memory, nor do their copies", "[pbd][unit]") {
  const auto resident = [] {  // bytes; 0 where the system does not tell
    std::ifstream file("/proc/self/statm");
    double all = 0.0;
    double pages = 0.0;
    file >> all >> pages;
    return 4096.0 * pages;
  };
  constexpr std::size_t kMany = 1 << 24;
  const double before = resident();
  SparseArray<double> array;
  array.resize(kMany);
  array[kMany / 2] = 1.0;
  array.resize(2 * kMany);
  const SparseArray<double> copy = array;
  CHECK(copy[kMany / 2] == 1.0);
  // An eighth for sanitizers that keep notes of all memory.
  CHECK(resident() - before < 0.25 * sizeof(double) * 4 * kMany);
}

TEST_CASE("sparse array: elements keep their alignment", "[pbd][unit]") {
  SparseArray<SolverBody> array;
  for (std::size_t size : {1, 50, 1000}) {
    array.resize(size);
    CHECK(reinterpret_cast<std::uintptr_t>(array.data()) % alignof(SolverBody) == 0);
  }
}

TEST_CASE("props table: static bodies share a record, and lose it when they are more",
          "[pbd][unit]") {
  PropsTable table;
  table.resize(4);
  CHECK(&table[0] == &table[3]);
  table.set(1, {.type = BodyType::Dynamic, .mass = 2.0});
  table.set(2, {.stable_id = 5});
  BodyProps signed_zero;
  signed_zero.origin.x() = -0.0;
  table.set(3, signed_zero);
  CHECK(table[0].mass == 0.0);
  CHECK(table[1].mass == 2.0);
  CHECK(table[2].stable_id == 5);
  CHECK(std::signbit(table[3].origin.x()));
  table.own(0).gravity_scale = 0.5;
  CHECK(table[0].gravity_scale == 0.5);
  table.set(1, {});
  CHECK(table[1].mass == 0.0);
  CHECK(table[1].gravity_scale == 1.0);
  table.own(1).mass = 3.0;  // in the place that was left
  CHECK(table[1].type == BodyType::Static);

  PropsTable copy;
  copy.assign(table);
  copy.own(0).gravity_scale = 2.0;
  CHECK(table[0].gravity_scale == 0.5);
  CHECK(copy[1].mass == 3.0);
}
