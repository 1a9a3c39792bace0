// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cell_wire.h"

#include <limits>

#include "net/protocol_support.h"
#include "octets.h"
#include "support/catch.h"

namespace tandem::nats::cell_wire_test {
namespace {

using pbd::Vec3;
using protocol::Bytes;

Bytes whole(const Summary& summary) {
  Bytes out;
  encode(summary, out);
  const auto signature = std::as_bytes(std::span(summary.signature));
  out.insert(out.end(), signature.begin(), signature.end());
  return out;
}

TEST_CASE("cell wire: encoded messages are decoded", "[nats]") {
  Bytes bytes;
  encode(Presence{.sent = -5, .position = Vec3(1.0, -2.0, 3.0), .hears = 8.0}, bytes);
  const auto presence = decode_presence(bytes);
  REQUIRE(presence.has_value());
  CHECK(presence->sent == -5);
  CHECK(presence->position == Vec3(1.0, -2.0, 3.0));
  CHECK(presence->hears == 8.0);
  const Bytes content = protocol::text("content");
  const Bytes said = whole({.cell = {2, -7, 9}, .people = 12, .content = content});
  const auto summary = decode_summary(said);
  REQUIRE(summary.has_value());
  CHECK(summary->cell == Cell{2, -7, 9});
  CHECK(summary->people == 12);
  CHECK(Bytes(summary->content.begin(), summary->content.end()) == content);
}

TEST_CASE("cell wire: numbers that cannot be are refused, and lengths are not believed",
          "[nats][fault]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const Presence& bad :
       {Presence{.position = Vec3(kNan, 0.0, 0.0)}, Presence{.position = Vec3(2e7, 0.0, 0.0)},
        Presence{.hears = -1.0}, Presence{.hears = kNan}, Presence{.hears = 1e300}}) {
    Bytes bytes;
    encode(bad, bytes);
    CHECK_FALSE(decode_presence(bytes).has_value());
  }
  for (const Cell& cell :
       {Cell{0, 0, 0}, Cell{6, 0, 0}, Cell{1, INT32_MIN, 0}, Cell{1, 0, INT32_MAX}}) {
    CHECK_FALSE(decode_summary(whole({.cell = cell})).has_value());
  }
  protocol::Dice dice(3);
  const Bytes good = whole({.cell = {1, 2, 3}, .content = protocol::text("content")});
  for (std::size_t length = 0; length < good.size(); ++length) {
    CHECK_FALSE(decode_summary(std::span(good).first(length)).has_value());
  }
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    bytes[dice.next() % bytes.size()] = static_cast<std::byte>(dice.next());
    const auto summary = decode_summary(bytes);
    if (summary) CHECK(summary->content.size() <= bytes.size());
    (void)decode_presence(protocol::random_bytes(dice, dice.next() % 80));
  }
}

}  // namespace
}  // namespace tandem::nats::cell_wire_test
