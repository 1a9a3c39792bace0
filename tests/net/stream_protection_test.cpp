// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "stream_protection.h"

#include <limits>

#include "support/catch.h"
#include "wire.h"

namespace stream_protection_test {

using namespace tandem::net;

namespace {

using Bytes = std::vector<std::byte>;

crypto::Secret secret(std::uint8_t fill) {
  std::array<std::uint8_t, 32> bytes{};
  bytes.fill(fill);
  return crypto::Secret(bytes);
}

Bytes plain(std::uint8_t fill, std::size_t size) {
  Bytes out;
  append_frame(out, FrameType::Newest, [&](tandem::pbd::ByteWriter& writer) {
    for (std::size_t i = 0; i < size; ++i) writer.u8(fill);
  });
  return out;
}

/// Type and payload, as they come out again.
Bytes body(const Bytes& frame) { return {frame.begin() + 4, frame.end()}; }

Bytes sealed(StreamSealer& sealer, const Bytes& frame, std::int64_t now = 0) {
  Bytes out;
  REQUIRE(sealer.seal(frame, now, out));
  return out;
}

bool opens_to(StreamOpener& opener, const Bytes& frame, const Bytes& expected) {
  const auto opened = opener.open(frame);
  return opened && Bytes(opened->begin(), opened->end()) == expected;
}

}  // namespace

TEST_CASE("stream protection: frames come out as they went in, at 16 bytes each", "[net][unit]") {
  StreamSealer sealer(secret(1), 0);
  StreamOpener opener(secret(1));
  for (const std::size_t size : {0, 1, 100, 65536}) {
    const Bytes frame = plain(7, size);
    const Bytes wire = sealed(sealer, frame);
    CHECK(wire.size() == frame.size() + 16);
    CHECK(opens_to(opener, wire, body(frame)));
  }
  // The same frame is never the same on the wire.
  CHECK(sealed(sealer, plain(7, 10)) != sealed(sealer, plain(7, 10)));
}

TEST_CASE("stream protection: each bit of a frame counts, its length's too", "[net][unit]") {
  for (std::size_t bit = 0; bit < 8 * (4 + 1 + 3 + 16); ++bit) {
    StreamSealer sealer(secret(1), 0);
    StreamOpener opener(secret(1));
    Bytes wire = sealed(sealer, plain(7, 3));
    wire[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    CHECK_FALSE(opener.open(wire));
    // Broken for good: the true frame comes too late.
    wire[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    CHECK_FALSE(opener.open(wire));
  }
}

TEST_CASE("stream protection: a frame opens at its place alone", "[net][unit]") {
  StreamSealer sealer(secret(1), 0);
  const Bytes first = sealed(sealer, plain(1, 5));
  const Bytes second = sealed(sealer, plain(2, 5));
  StreamOpener repeated(secret(1));
  CHECK(repeated.open(first));
  CHECK_FALSE(repeated.open(first));
  StreamOpener early(secret(1));
  CHECK_FALSE(early.open(second));
  StreamOpener other(secret(2));
  CHECK_FALSE(other.open(first));
}

TEST_CASE("stream protection: keys change by count and by time, and both ends go along",
          "[net][unit]") {
  StreamSealer sealer(secret(1), 0, {.packets = 3, .period = 1000});
  StreamOpener opener(secret(1));
  std::uint64_t opened = 0;
  const auto pass = [&](std::int64_t now) {
    const Bytes wire = sealed(sealer, plain(9, 20), now);
    FrameBuffer frames(100);
    std::copy(wire.begin(), wire.end(), frames.space().begin());
    frames.filled(wire.size());
    while (const auto whole = frames.next_whole(17)) {
      const auto out = opener.open(*whole);
      REQUIRE(out);
      opened += out->empty() ? 0 : 1;
    }
  };
  for (int i = 0; i < 10; ++i) pass(0);
  CHECK(opened == 10);
  CHECK(sealer.epoch() == 3);
  pass(1000);
  CHECK(sealer.epoch() == 4);
  CHECK(opener.epoch() == 4);
  // The key before is of no use any more.
  StreamSealer old(secret(1), 0, {}, 16);
  CHECK_FALSE(opener.open(sealed(old, plain(9, 20))));
}

TEST_CASE("stream protection: the last number is used once and ends the connection",
          "[net][unit]") {
  constexpr std::uint64_t kLast = std::numeric_limits<std::uint64_t>::max();
  StreamSealer sealer(secret(1), 0, {}, kLast);
  StreamOpener opener(secret(1), kLast);
  const Bytes wire = sealed(sealer, plain(1, 1));
  CHECK(opener.open(wire));
  Bytes out;
  CHECK_FALSE(sealer.seal(plain(1, 1), 0, out));
  CHECK(out.empty());
  CHECK_FALSE(opener.open(wire));
}

}  // namespace stream_protection_test
