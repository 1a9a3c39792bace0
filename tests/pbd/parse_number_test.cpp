// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/parse_number.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <string>

using tandem::pbd::detail::parse_number;

TEST_CASE("parse_number: the whole of a text, as strtod has it", "[validate]") {
  for (const std::string text : {"0", "-0", "1", "-2.5", ".5", "5.", "1e3", "1E-3", "1e+3", "0.1",
                                 "123456789.123456789", "1.7976931348623157e308", "-1e-300"}) {
    CAPTURE(text);
    double value = 7.0;
    REQUIRE(parse_number(text, value));
    CHECK(value == std::stod(text));
  }
}

TEST_CASE("parse_number: anything else is refused", "[validate]") {
  for (const std::string text : {"", " 1", "1 ", "+1", "1,5", "1.5.2", "e3", "1e", "--1", "0x10",
                                 "1f", "1e400", "one", ".", "-"}) {
    CAPTURE(text);
    double value = 0.0;
    CHECK_FALSE(parse_number(text, value));
  }
  std::uint16_t port = 0;
  CHECK_FALSE(parse_number("65536", port));
  CHECK_FALSE(parse_number("-1", port));
  CHECK_FALSE(parse_number("80 ", port));
  REQUIRE(parse_number("65535", port));
  CHECK(port == std::numeric_limits<std::uint16_t>::max());
}
