// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/bytes.h"

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string_view>

#include "support/catch.h"

namespace bytes_test {

using namespace tandem::pbd;

namespace {

std::vector<std::byte> raw(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

}  // namespace

TEST_CASE("bytes: every kind of value comes back bit for bit", "[pbd][unit]") {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  out.u8(0xfe);
  out.u16(0xbeef);
  out.u32(0xdeadbeefu);
  out.u64(0x0123456789abcdefull);
  out.i64(std::numeric_limits<std::int64_t>::min());
  out.i64(-1);
  out.f32(-1.5e-40f);  // subnormal
  out.f64(-0.0);
  out.f64(std::numeric_limits<double>::quiet_NaN());
  out.vec3(Vec3(1.0 / 3.0, -1e300, 5e-324));
  out.quat(Quat(0.1, 0.2, 0.3, 0.4));
  out.bytes(raw({7, 8, 9}));
  CHECK(bytes.size() == 1 + 2 + 4 + 8 + 8 + 8 + 4 + 8 + 8 + 24 + 32 + 3);

  ByteReader in(bytes);
  CHECK(in.u8() == 0xfe);
  CHECK(in.u16() == 0xbeef);
  CHECK(in.u32() == 0xdeadbeefu);
  CHECK(in.u64() == 0x0123456789abcdefull);
  CHECK(in.i64() == std::numeric_limits<std::int64_t>::min());
  CHECK(in.i64() == -1);
  CHECK(in.f32() == -1.5e-40f);
  CHECK(std::signbit(in.f64()));
  CHECK(std::isnan(in.f64()));
  CHECK(in.vec3() == Vec3(1.0 / 3.0, -1e300, 5e-324));
  const Quat q = in.quat();
  CHECK((q.w() == 0.1 && q.x() == 0.2 && q.y() == 0.3 && q.z() == 0.4));
  CHECK(in.remaining() == 3);
  const auto view = in.bytes(3);
  CHECK(std::vector<std::byte>(view.begin(), view.end()) == raw({7, 8, 9}));
  CHECK(in.remaining() == 0);
  CHECK_FALSE(in.failed());
}

TEST_CASE("bytes: values are laid out little-endian, IEEE 754", "[pbd][unit][golden]") {
  std::vector<std::byte> bytes;
  ByteWriter out(bytes);
  out.u16(0x0102);
  out.u32(0x03040506u);
  out.u64(0x0708090a0b0c0d0eull);
  out.i64(-2);
  out.f32(1.0f);                                                              // 3f800000
  out.f64(-2.5);                                                              // c004000000000000
  out.quat(Quat(1.0, 0.0, 0.0, 0.0));                                         // w first
  const auto expected = raw({0x02, 0x01,                                      // u16
                             0x06, 0x05, 0x04, 0x03,                          // u32
                             0x0e, 0x0d, 0x0c, 0x0b, 0x0a, 0x09, 0x08, 0x07,  // u64
                             0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,  // i64
                             0x00, 0x00, 0x80, 0x3f,                          // f32
                             0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04, 0xc0,  // f64
                             0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0x3f,  // quat w
                             0,    0,    0,    0,    0,    0,    0,    0,    0, 0, 0, 0,
                             0,    0,    0,    0,    0,    0,    0,    0,    0, 0, 0, 0});
  CHECK(bytes == expected);
}

TEST_CASE("bytes: a read past the end gives zero and fails for good", "[pbd][fault]") {
  const auto bytes = raw({1, 2, 3, 4, 5});
  ByteReader in(bytes);
  CHECK(in.u32() == 0x04030201u);
  CHECK(in.u32() == 0u);  // one byte is left, four are wanted
  CHECK(in.failed());
  CHECK(in.u8() == 0);  // there would be a byte, but the reader has given up
  CHECK(in.f64() == 0.0);
  CHECK(in.vec3() == Vec3(0.0, 0.0, 0.0));
  CHECK(in.bytes(1).empty());
  CHECK(in.failed());
}

TEST_CASE("bytes: a view longer than the input fails, also where the length would overflow",
          "[pbd][fault]") {
  const auto bytes = raw({1, 2, 3});
  for (const std::size_t length : {std::size_t{4}, std::numeric_limits<std::size_t>::max()}) {
    ByteReader in(bytes);
    in.u8();
    CHECK(in.bytes(length).empty());
    CHECK(in.failed());
  }
  ByteReader exact(bytes);
  CHECK(exact.bytes(3).size() == 3);
  CHECK_FALSE(exact.failed());
  CHECK(exact.bytes(0).empty());
  CHECK_FALSE(exact.failed());
}

TEST_CASE("bytes: an empty input has nothing to read", "[pbd][fault]") {
  ByteReader in({});
  CHECK(in.remaining() == 0);
  CHECK_FALSE(in.failed());
  CHECK(in.u8() == 0);
  CHECK(in.failed());
}

TEST_CASE("bytes: hash_bytes is 64-bit FNV-1a and chains", "[pbd][unit][golden]") {
  const auto hash = [](std::string_view text, auto... seed) {
    return hash_bytes(std::as_bytes(std::span(text.data(), text.size())), seed...);
  };
  // Values from the algorithm's published test vectors.
  CHECK(hash("") == 0xcbf29ce484222325ull);
  CHECK(hash("a") == 0xaf63dc4c8601ec8cull);
  CHECK(hash("foobar") == 0x85944171f73967e8ull);
  CHECK(hash("bar", hash("foo")) == hash("foobar"));
}

}  // namespace bytes_test
