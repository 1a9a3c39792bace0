// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "packet_protection.h"

#include <algorithm>
#include <set>
#include <utility>

#include "octets.h"
#include "protocol_support.h"
#include "support/catch.h"

namespace packet_protection_test {

using namespace tandem::net;
using namespace protocol;

namespace {

Bytes sealed(PacketSealer& sealer, const Bytes& plain, std::int64_t now = 0) {
  Bytes out;
  REQUIRE(sealer.seal(plain, now, out));
  return out;
}

bool opens(PacketOpener& opener, const Bytes& datagram) {
  Bytes buffer;
  return opener.open(datagram, buffer).has_value();
}

/// The window's expected answer, from a list of everything received.
class BruteWindow {
 public:
  bool fresh(std::uint64_t sequence) const {
    if (sequence == 0 || had_.contains(sequence)) return false;
    if (had_.empty()) return true;
    const std::uint64_t latest = *had_.rbegin();
    return sequence > latest || latest - sequence <= 255;
  }
  void note(std::uint64_t sequence) { had_.insert(sequence); }

 private:
  std::set<std::uint64_t> had_;
};

}  // namespace

TEST_CASE("protection: sealed bytes are those of another implementation", "[net][golden]") {
  // Computed by OpenSSL 3.0: ChaCha20-Poly1305 with the nonce 00000000 | counter, little-endian.
  crypto::Secret key;
  for (std::size_t i = 0; i < crypto::kKeyBytes; ++i) {
    key.bytes()[i] = static_cast<std::uint8_t>(0x80 + i);
  }
  const auto plain = unhex("4c616469657320616e642047656e746c656d656e");
  const auto header = unhex("50515253c0c1c2c3c4c5c6c7");
  std::vector<std::uint8_t> out(plain.size() + crypto::kTagBytes);
  crypto::seal(key, 0x4746454443424140, header, plain, out);
  CHECK(out == unhex("a479cb54628946d6f4042a8e384ef4bd2fbc733081542c6cc1c348f28440dd858f05f7e0"));
}

TEST_CASE("protection: a sealed packet opens once", "[net][fault]") {
  PacketSealer sealer(secret(1), 77, 0);
  PacketOpener opener(secret(1));
  Bytes buffer;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{500}, kMaxDatagram - kProtectedOverhead}) {
    Dice dice(size);
    const Bytes plain = random_bytes(dice, size);
    const Bytes datagram = sealed(sealer, plain);
    CHECK(datagram.size() == size + kProtectedOverhead);
    CHECK(decode_protected_header(datagram)->receiver == 77);
    const auto opened = opener.open(datagram, buffer);
    REQUIRE(opened);
    CHECK(copy(opened->plain) == plain);
    CHECK_FALSE(opens(opener, datagram));
  }
  CHECK(opener.counters().opened == 4);
  CHECK(opener.counters().replayed == 4);
  Bytes out;
  CHECK_FALSE(sealer.seal(Bytes(kMaxDatagram - kProtectedOverhead + 1), 0, out));
}

TEST_CASE("protection: no bit of a packet can be changed, none added or taken away",
          "[net][fault]") {
  PacketSealer sealer(secret(1), 77, 0);
  PacketOpener opener(secret(1));
  const Bytes good = sealed(sealer, text("a state"));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    CHECK_FALSE(opens(opener, bad));
  }
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_FALSE(opens(opener, Bytes(good.begin(), good.begin() + static_cast<long>(size))));
  }
  Bytes longer = good;
  longer.push_back(std::byte{});
  CHECK_FALSE(opens(opener, longer));
  longer.resize(kMaxDatagram + 1);
  CHECK_FALSE(opens(opener, longer));
  PacketOpener other(secret(2));
  CHECK_FALSE(opens(other, good));
  CHECK(opener.counters().opened == 0);
  CHECK(opens(opener, good));  // and none of this has spoilt the right one
}

TEST_CASE("protection: a forged number of any height does not move the window", "[net][fault]") {
  PacketSealer sealer(secret(1), 77, 0);
  PacketOpener opener(secret(1));
  const Bytes first = sealed(sealer, text("1"));
  const Bytes second = sealed(sealer, text("2"));
  CHECK(opens(opener, second));
  Bytes forged = first;
  std::fill(forged.begin() + 5, forged.begin() + 13, std::byte{0xff});
  CHECK_FALSE(opens(opener, forged));
  CHECK(opener.window().latest() == 2);
  CHECK(opens(opener, first));
}

TEST_CASE("protection: the window agrees with a list of all numbers, to the top of the range",
          "[net][analytic]") {
  for (const std::uint64_t start :
       {std::uint64_t{1}, std::uint64_t{1} << 32, ~std::uint64_t{0} - 3000}) {
    ReplayWindow window;
    BruteWindow brute;
    Dice dice(start);
    std::uint64_t around = start;
    for (int i = 0; i < 20'000; ++i) {
      around += dice.below(100) == 0 ? dice.below(600) : dice.below(3);
      std::uint64_t sequence = around + dice.below(4) - dice.below(600);
      if (start == 1 && sequence > around + 4) sequence = 0;
      if (start > 1 && i > 50 && around < start) break;  // wrapped
      const bool fresh = brute.fresh(sequence);
      REQUIRE(window.fresh(sequence) == fresh);
      if (fresh && dice.below(4) != 0) {
        window.note(sequence);
        brute.note(sequence);
      }
    }
  }
}

TEST_CASE("protection: the last number is used once, then the connection is over", "[net][fault]") {
  PacketSealer sealer(secret(1), 77, 0, {}, ~std::uint64_t{0} - 1);
  PacketOpener opener(secret(1));
  const Bytes last_but_one = sealed(sealer, text("a"));
  const Bytes last = sealed(sealer, text("b"));
  Bytes out;
  CHECK(sealer.next_sequence() == 0);
  CHECK_FALSE(sealer.seal(text("c"), 0, out));
  CHECK_FALSE(sealer.seal(text("c"), 0, out));
  CHECK(opens(opener, last));
  CHECK(opens(opener, last_but_one));
  CHECK_FALSE(opens(opener, last));
  CHECK_FALSE(opens(opener, last_but_one));
}

TEST_CASE("protection: keys change by packets and by time, under loss and disorder",
          "[net][fault]") {
  const RekeyPolicy policy{.packets = 300, .period = 10 * kSecond};
  PacketSealer sealer(secret(1), 77, 0, policy);
  PacketOpener opener(secret(1));
  Dice dice(3);
  std::vector<Bytes> all;
  for (int i = 0; i < 3000; ++i) all.push_back(sealed(sealer, text("x")));
  // Blocks of 40 packets come in any order, so that some come with the key before.
  std::uint64_t arrived = 0;
  for (std::size_t block = 0; block < all.size(); block += 40) {
    for (std::size_t left = 40; left > 0; --left) {
      std::swap(all[block + dice.below(left)], all[block + left - 1]);
      if (dice.chance(0.25)) continue;
      REQUIRE(opens(opener, all[block + left - 1]));
      ++arrived;
    }
  }
  CHECK(sealer.epoch() == 9);  // ten keys for 3000 packets
  CHECK(opener.epoch() == 9);
  CHECK(opener.counters().opened == arrived);
  // An old key opens nothing any more.
  for (std::size_t i = 0; i < 2700; ++i) CHECK_FALSE(opens(opener, all[i]));

  CHECK(opens(opener, sealed(sealer, text("x"), 10 * kSecond)));
  CHECK(opener.epoch() == 10);
}

TEST_CASE("protection: a key leads to the next, and the next to another", "[net]") {
  const crypto::Secret first = secret(1);
  const crypto::Secret second = crypto::next_key(first);
  CHECK_FALSE(first == second);
  CHECK_FALSE(second == crypto::next_key(second));
  CHECK(second == crypto::next_key(first));
}

TEST_CASE("protection: junk is counted and nothing else", "[net][fault]") {
  PacketOpener opener(secret(1));
  Dice dice(9);
  Bytes buffer;
  for (int i = 0; i < 20'000; ++i) {
    Bytes junk = random_bytes(dice, dice.below(1400));
    if (!junk.empty() && dice.chance(0.5)) junk[0] = std::byte{kProtectedType};
    CHECK_FALSE(opener.open(junk, buffer));
  }
  const auto& counters = opener.counters();
  CHECK(counters.malformed + counters.forged + counters.replayed == 20'000);
  CHECK(counters.forged > 1000);
  CHECK(opener.window().latest() == 0);
  CHECK(opener.epoch() == 0);
  CHECK(buffer.capacity() <= kMaxDatagram + kProtectedOverhead + kRelayHeader);
}

}  // namespace packet_protection_test
