// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/shared_id.h"

#include <algorithm>
#include <set>
#include <vector>

#include "consensus/random.h"
#include "support/catch.h"

namespace shared_id_test {

using tandem::consensus::SharedId;
using tandem::consensus::testing::Dice;

TEST_CASE("shared_id: names hash by 128-bit FNV-1a as published", "[consensus][golden]") {
  // Test vectors of the FNV reference code.
  CHECK(SharedId::from_name("") == SharedId{0x6c62272e07bb0142, 0x62b821756295c58d});
  CHECK(SharedId::from_name("a") == SharedId{0xd228cb696f1a8caf, 0x78912b704e4a8964});
  CHECK(SharedId::from_name("foobar") == SharedId{0x343e1662793c64bf, 0x6f0d3597ba446f18});
}

TEST_CASE("shared_id: ten thousand numbered names get distinct ids", "[consensus][unit]") {
  std::set<SharedId> ids;
  for (int i = 0; i < 10000; ++i) ids.insert(SharedId::from_name("cube " + std::to_string(i)));
  CHECK(ids.size() == 10000);
  CHECK(ids.begin()->valid());
}

TEST_CASE("shared_id: the written form is that of a GUID", "[consensus][unit]") {
  const SharedId id{0x0123456789abcdef, 0xfedcba9876543210};
  CHECK(id.to_string() == "01234567-89ab-cdef-fedc-ba9876543210");
  CHECK(SharedId::parse("01234567-89ab-cdef-fedc-ba9876543210") == id);
  CHECK(SharedId::parse("01234567-89AB-CDEF-FEDC-BA9876543210") == id);
  CHECK(SharedId::parse("0123456789abcdeffedcba9876543210") == id);
}

TEST_CASE("shared_id: a written id reads back, and ids sort as their texts", "[consensus][unit]") {
  Dice dice(7);
  std::vector<SharedId> ids;
  for (int i = 0; i < 200; ++i) ids.push_back({dice.bits(), dice.bits()});
  for (const SharedId& id : ids) CHECK(SharedId::parse(id.to_string()) == id);
  std::sort(ids.begin(), ids.end());
  CHECK(std::is_sorted(ids.begin(), ids.end(), [](const SharedId& a, const SharedId& b) {
    return a.to_string() < b.to_string();
  }));
}

TEST_CASE("shared_id: text that is no GUID is refused", "[consensus][fault]") {
  for (const char* text :
       {"", "0", "01234567-89ab-cdef-fedc-ba987654321", "01234567-89ab-cdef-fedc-ba98765432100",
        "0123456789abcdeffedcba987654321g", "01234567x89ab-cdef-fedc-ba9876543210",
        "0123456-789ab-cdef-fedc-ba9876543210", "{1234567-89ab-cdef-fedc-ba987654321}",
        " 123456789abcdeffedcba9876543210", "01234567-89ab-cdef-fedc-ba98765432-0"}) {
    INFO(text);
    CHECK_FALSE(SharedId::parse(text).has_value());
  }
}

TEST_CASE("shared_id: zeros name nothing", "[consensus][unit]") {
  CHECK_FALSE(SharedId{}.valid());
  CHECK(SharedId{0, 1}.valid());
  CHECK(SharedId{1, 0}.valid());
}

}  // namespace shared_id_test
