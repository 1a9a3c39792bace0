// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cipher/cipher.h"

#include <algorithm>
#include <random>
#include <set>
#include <string>

#include "support/catch.h"

namespace tandem::room::cipher_test {
namespace {

using Kind = Cipher::Kind;

Random seeded(unsigned seed) {
  return [engine = std::mt19937(seed)](std::span<std::uint8_t> bytes) mutable {
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(engine());
  };
}

const Bytes kKey(kKeyBytes, 7);
const Bytes kText = {'h', 'e', 'l', 'l', 'o'};

struct Pair {
  Cipher a{kKey, "sandbox", 1, seeded(1)};
  Cipher b{kKey, "sandbox", 2, seeded(2)};
  Bytes out;

  Pair() {
    CHECK(b.open(1, a.hello(kText), out) == Kind::Hello);
    CHECK(out == kText);
    CHECK(a.open(2, b.hello({}), out) == Kind::Hello);
  }
  Bytes sealed(const Bytes& plain = kText) {
    Bytes bytes;
    REQUIRE(a.seal(2, plain, bytes));
    return bytes;
  }
};

TEST_CASE("room cipher: a sealed message opens once at the other end") {
  Pair pair;
  const Bytes bytes = pair.sealed();
  CHECK(std::search(bytes.begin(), bytes.end(), kText.begin(), kText.end()) == bytes.end());
  CHECK_FALSE(pair.b.alive(1));
  CHECK(pair.b.open(1, bytes, pair.out) == Kind::Packet);
  CHECK(pair.out == kText);
  CHECK(pair.b.alive(1));
  CHECK(pair.b.open(1, bytes, pair.out) == Kind::Refused);
  CHECK(pair.out.empty());
}

TEST_CASE("room cipher: out of order within the window, each once") {
  Pair pair;
  std::vector<Bytes> all;
  for (int i = 0; i < 5000; ++i) all.push_back(pair.sealed());
  CHECK(pair.b.open(1, all[4999], pair.out) == Kind::Packet);
  CHECK(pair.b.open(1, all[4999 - 4095], pair.out) == Kind::Packet);
  CHECK(pair.b.open(1, all[4999 - 4095], pair.out) == Kind::Refused);
  CHECK(pair.b.open(1, all[4999 - 4096], pair.out) == Kind::Refused);
  CHECK(pair.b.open(1, all[2000], pair.out) == Kind::Packet);
  CHECK(pair.b.open(1, pair.sealed(), pair.out) == Kind::Packet);
  CHECK(pair.b.open(1, all[2000], pair.out) == Kind::Refused);
  CHECK(pair.b.open(1, all[2001], pair.out) == Kind::Packet);
}

TEST_CASE("room cipher: any changed bit is refused") {
  Pair pair;
  const Bytes hello = pair.a.hello(kText);
  Cipher third(kKey, "sandbox", 3, seeded(3));
  for (const Bytes& good : {pair.sealed(), hello}) {
    Cipher& reader = good == hello ? third : pair.b;
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      Bytes bad = good;
      bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1U << bit % 8);
      CHECK(reader.open(1, bad, pair.out) == Kind::Refused);
    }
    for (std::size_t size = 0; size < good.size(); ++size) {
      CHECK(reader.open(1, View(good).first(size), pair.out) == Kind::Refused);
    }
  }
  CHECK(third.open(1, hello, pair.out) == Kind::Hello);
}

TEST_CASE("room cipher: not for another key, room, sender or receiver") {
  Pair pair;
  const Bytes packet = pair.sealed();
  const Bytes hello = pair.a.hello({});
  Bytes key = kKey;
  key[31] ^= 1;
  Cipher other_key(key, "sandbox", 2, seeded(2));
  Cipher other_room(kKey, "piano", 2, seeded(2));
  CHECK(other_key.open(1, hello, pair.out) == Kind::Refused);
  CHECK(other_room.open(1, hello, pair.out) == Kind::Refused);
  // A server that says it came from somebody else, or hands it to a third.
  Cipher third(kKey, "sandbox", 3, seeded(3));
  CHECK(pair.b.open(3, third.hello({}), pair.out) == Kind::Hello);
  CHECK(pair.b.open(3, packet, pair.out) == Kind::Refused);
  CHECK(third.open(1, hello, pair.out) == Kind::Hello);
  CHECK(third.open(1, packet, pair.out) == Kind::Refused);
  // Back to its sender.
  CHECK(pair.a.open(2, packet, pair.out) == Kind::Refused);
  CHECK(pair.a.open(1, hello, pair.out) == Kind::Refused);
}

TEST_CASE("room cipher: recordings of another life open nothing") {
  Pair pair;
  const Bytes packet = pair.sealed();
  // The receiver has started again under its id: its life is another one.
  Cipher again(kKey, "sandbox", 2, seeded(22));
  CHECK(again.open(1, pair.a.hello({}), pair.out) == Kind::Hello);
  CHECK(again.open(1, packet, pair.out) == Kind::Refused);
  CHECK_FALSE(again.alive(1));
  // And an id has one life: who has spoken with it goes on with that.
  CHECK(pair.a.open(2, again.hello({}), pair.out) == Kind::Refused);
}

TEST_CASE("room cipher: a member that is greeted again goes on with its counters") {
  Pair pair;
  std::set<std::string> headers;
  for (int i = 0; i < 3; ++i) {
    const Bytes bytes = pair.sealed();
    headers.insert(std::string(bytes.begin(), bytes.begin() + 9));
    CHECK(pair.a.open(2, pair.b.hello({}), pair.out) == Kind::Known);
  }
  CHECK(headers.size() == 3);  // no counter twice with one key
}

TEST_CASE("room cipher: limits") {
  Pair pair;
  Bytes bytes;
  CHECK(pair.a.seal(2, Bytes(kMaxPlainBytes), bytes));
  CHECK(pair.b.open(1, bytes, pair.out) == Kind::Packet);
  CHECK_FALSE(pair.a.seal(2, Bytes(kMaxPlainBytes + 1), bytes));
  CHECK_FALSE(pair.a.seal(9, kText, bytes));
  CHECK_THROWS_AS(pair.a.hello(Bytes(kMaxProfileBytes + 1)), std::invalid_argument);
  CHECK_THROWS_AS(Cipher(Bytes(31), "sandbox", 1, seeded(1)), std::invalid_argument);
  CHECK_THROWS_AS(Cipher(kKey, "sandbox", 0, seeded(1)), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::room::cipher_test
