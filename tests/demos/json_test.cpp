// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/json.h"

#include <cstdint>
#include <limits>

#include "support/catch.h"

namespace tandem::demos::json_test {
namespace {

TEST_CASE("json: strings are escaped as RFC 8259 wants", "[demos][unit]") {
  CHECK(json_string("plain") == R"("plain")");
  CHECK(json_string("a\"b\\c") == R"("a\"b\\c")");
  CHECK(json_string("line\nand\ttab") == R"("line\nand\ttab")");
  CHECK(json_string(std::string_view("\0\x01\x1f", 3)) == R"("\u0000\u0001\u001f")");
  CHECK(json_string("Gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80") ==
        "\"Gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80\"");
}

TEST_CASE("json: bytes that are no UTF-8 do not get out", "[demos][fault]") {
  CHECK(json_string("\xff") == R"("\ufffd")");
  CHECK(json_string("\xc3") == R"("\ufffd")");                        // cut off
  CHECK(json_string("\xc0\xaf") == R"("\ufffd\ufffd")");              // overlong
  CHECK(json_string("\xed\xa0\x80x") == R"("\ufffd\ufffd\ufffdx")");  // surrogate
}

TEST_CASE("json: numbers keep every bit, NaN and infinity become null", "[demos][unit]") {
  JsonWriter json;
  json.begin_array();
  json.value(0.1).value(1e-300).value(std::numeric_limits<double>::quiet_NaN());
  json.value(std::numeric_limits<double>::infinity()).value(std::uint64_t{18446744073709551615u});
  json.value(-3).value(true).null();
  json.end_array();
  CHECK(json.text() ==
        "[\n  0.1,\n  1e-300,\n  null,\n  null,\n  18446744073709551615,\n  -3,\n  true,\n"
        "  null\n]\n");
}

TEST_CASE("json: objects nest with commas where they belong", "[demos][unit]") {
  JsonWriter json;
  json.begin_object();
  json.field("a", 1).field("b\"", "x");
  json.key("empty").begin_object().end_object();
  json.key("list").begin_array().value(1).value(2).end_array();
  json.null_field("none");
  json.end_object();
  CHECK(
      json.text() ==
      "{\n  \"a\": 1,\n  \"b\\\"\": \"x\",\n  \"empty\": {},\n  \"list\": [\n    1,\n    2\n  ],\n"
      "  \"none\": null\n}\n");
}

}  // namespace
}  // namespace tandem::demos::json_test
