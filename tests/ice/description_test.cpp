// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "description.h"

#include <stdexcept>
#include <string>

#include "support/catch.h"

namespace ice_description_test {

using namespace tandem::ice;

TEST_CASE("ice description: a written description reads back", "[ice]") {
  Description out;
  out.ufrag = "aB+/";
  out.password = "0123456789abcdefghijkl";
  out.candidates = {
      "candidate:1 1 UDP 2015363327 10.0.0.1 4000 typ host",
      "candidate:2 1 UDP 1677721855 192.0.2.1 4000 typ srflx raddr 10.0.0.1 rport 4000"};
  const Description in = parse_description(encode(out));
  CHECK(in.ufrag == out.ufrag);
  CHECK(in.password == out.password);
  CHECK(in.candidates == out.candidates);
}

TEST_CASE("ice description: foreign descriptions are checked", "[ice][fault]") {
  const std::string good =
      "tandem-ice 1\nufrag abcd\npwd 0123456789abcdefghijkl\n"
      "candidate:1 1 UDP 1 10.0.0.1 4000 typ host\n";
  CHECK_NOTHROW(parse_description(good));
  CHECK_NOTHROW(parse_description("\r\n" + good));
  for (const std::string& bad :
       {std::string(), std::string("tandem-ice 1"), "tandem-ice 2" + good.substr(12),
        good.substr(0, good.find("candidate")), "tandem-ice 1\nufrag ab\n" + good.substr(24),
        good + "a=sendrecv\n", good + "candidate:\x01\n",
        good + "candidate:" + std::string(400, 'x'), good + std::string(20'000, '\n'),
        std::string("tandem-ice 1\nufrag abcd\npwd short\ncandidate:1")}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(parse_description(bad), std::invalid_argument);
  }
  std::string many = good;
  for (int i = 0; i < 64; ++i) many += "candidate:1 1 UDP 1 10.0.0.1 4000 typ host\n";
  CHECK_THROWS_AS(parse_description(many), std::invalid_argument);
}

}  // namespace ice_description_test
