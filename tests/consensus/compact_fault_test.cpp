// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <limits>

#include "consensus/updates.h"
#include "support/catch.h"
#include "tandem/consensus/compact.h"

namespace compact_fault_test {

using namespace tandem;
using namespace tandem::consensus;
using tandem::consensus::testing::Dice;
using tandem::consensus::testing::some_spring;
using tandem::consensus::testing::some_state;

namespace {

using Bytes = std::vector<std::byte>;

// The layout of a message with states: header 6, stamp 8, table 4, influence 2, length 2, bits.
constexpr std::size_t kLength = 20;
constexpr std::size_t kBits = 22;

/// Every kind of message.
Bytes everything() {
  Dice dice(51);
  std::vector<IndexedState> states;
  for (std::uint16_t i = 0; i < 6; ++i) {
    StateUpdate update = some_state(dice);
    update.stamp = 77;
    update.flags.resting = i % 2 == 0;
    update.oriented = i % 3 != 0;
    if (i == 5) update.twist.linear = {1000.0, 0.0, 0.0};
    states.push_back({static_cast<std::uint16_t>(50 * i), update});
  }
  Bytes bytes;
  encode_compact(states, 3, 4096, bytes);
  const std::vector<SharedId> ids = {{1, 2}, {3, 4}};
  encode_indices(3, 10, ids, bytes);
  encode(IndicesWanted{4}, bytes);
  encode(Alive{5}, bytes);
  SpringUpdate spring = some_spring(dice);
  std::vector<SpringUpdate> others;
  encode_anchors(std::span(&spring, 1), 8192, others, bytes);
  return bytes;
}

/// One record whose bits are given as (value, width), behind a header that counts it.
Bytes record(const std::vector<std::pair<std::uint64_t, unsigned>>& fields, unsigned count = 1) {
  Bytes bytes(kBits, std::byte{0});
  bytes[0] = std::byte{0x54};
  bytes[1] = std::byte{0x43};
  bytes[2] = static_cast<std::byte>(kPacketVersion);
  bytes[3] = std::byte{5};
  bytes[4] = static_cast<std::byte>(count);
  std::size_t bit = 0;
  for (const auto& [value, width] : fields) {
    for (unsigned i = 0; i < width; ++i, ++bit) {
      if (bit % 8 == 0) bytes.push_back(std::byte{0});
      if ((value >> i & 1) != 0) bytes.back() |= static_cast<std::byte>(1u << bit % 8);
    }
  }
  bytes[kLength] = static_cast<std::byte>((bytes.size() - kBits) & 0xff);
  return bytes;
}

CodecResult decoded(const Bytes& bytes) {
  DecodedPacket packet;
  packet.compact.resize(3);
  packet.assignments.resize(2);
  packet.anchors.resize(2);
  packet.alive.resize(1);
  packet.indices_wanted.resize(1);
  const CodecResult result = decode(bytes, packet);
  if (!result.ok()) {
    CHECK((packet.compact.empty() && packet.assignments.empty() && packet.anchors.empty() &&
           packet.alive.empty() && packet.indices_wanted.empty()));
  }
  return result;
}

// A resting body at the origin without an orientation: gap 1, rests, touches, nothing rare, usual
// influence, same cell, position.
const std::vector<std::pair<std::uint64_t, unsigned>> kResting = {{0, 1}, {1, 1}, {1, 1}, {0, 1},
                                                                  {0, 1}, {0, 1}, {0, 54}};

std::vector<std::pair<std::uint64_t, unsigned>> with(
    std::vector<std::pair<std::uint64_t, unsigned>> fields,
    const std::vector<std::pair<std::uint64_t, unsigned>>& more) {
  fields.insert(fields.end(), more.begin(), more.end());
  return fields;
}

}  // namespace

TEST_CASE("compact: bits written by hand are understood", "[consensus][golden]") {
  DecodedPacket packet;
  Bytes bytes = record(with(kResting, {{0, 1}}));
  bytes[6] = std::byte{9};     // stamp
  bytes[14] = std::byte{8};    // table
  bytes[18] = std::byte{255};  // influence
  bytes[19] = std::byte{255};
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.compact.size() == 1);
  CHECK(packet.compact[0].index == 0);
  CHECK(packet.compact[0].table == 8);
  const StateUpdate& update = packet.compact[0].update;
  CHECK(update.stamp == 9);
  CHECK(update.influence == 1.0f);
  CHECK(update.flags == UpdateFlags{.in_contact = true, .resting = true});
  CHECK(update.pose.position.isZero(0.0));
  CHECK_FALSE(update.oriented);

  // A gap of 2 + 3, moving, held, influence 0, cell (1, 0, -1), position (1, 0, -1) quanta, turned
  // by half a turn about y, v = (-1, 0, 0) quanta, w = (0, 0, 2) quanta.
  const std::uint64_t all = ~std::uint64_t{0};
  REQUIRE(decode(record({{1, 1},  {0, 1}, {3, 4},  {0, 1},  {0, 1},    {1, 1},  {1, 4},  {1, 1},
                         {0, 16}, {1, 1}, {1, 20}, {0, 20}, {all, 20}, {1, 18}, {0, 18}, {all, 18},
                         {1, 1},  {2, 2}, {0, 45}, {0, 1},  {all, 17}, {0, 34}, {0, 32}, {2, 16}}),
                 packet)
              .ok());
  const CompactState& state = packet.compact.at(0);
  CHECK(state.index == 4);
  CHECK(state.update.flags == UpdateFlags{.held = true});
  CHECK(state.update.pose.position == pbd::Vec3(64.0 + 1.0 / 4096.0, 0.0, -64.0 - 1.0 / 4096.0));
  CHECK(state.update.pose.orientation.y() == 1.0);
  CHECK(state.update.twist.linear == pbd::Vec3(-1.0 / 1024.0, 0.0, 0.0));
  CHECK(state.update.twist.angular == pbd::Vec3(0.0, 0.0, 2.0 / 1024.0));
}

TEST_CASE("compact: records that cannot be are refused by name", "[consensus][fault]") {
  const std::uint64_t most = 16383;
  // Three components of sqrt(1/2): no unit quaternion has them.
  CHECK(
      decoded(record(with(kResting, {{1, 1}, {0, 2}, {most, 15}, {most, 15}, {most, 15}}))).fault ==
      PacketFault::OutOfRange);
  CHECK(decoded(record(with(kResting, {{1, 1}, {0, 2}, {0x4000, 15}, {0, 30}}))).fault ==
        PacketFault::BadCode);
  // The last index is 65535: the first record's gap of 65536 is it, one more is none.
  const auto far = [](std::uint64_t gap) {
    return record({{1, 1}, {1, 1}, {gap - 2, 16}, {1, 1}, {1, 1}, {0, 3}, {0, 54}, {0, 1}});
  };
  CHECK(decoded(far(65536)).ok());
  CHECK(decoded(far(65537)).fault == PacketFault::BadId);
  // A cell beyond 1e7 m.
  CHECK(
      decoded(
          record({{0, 1}, {1, 1}, {1, 1}, {0, 2}, {1, 1}, {200'000, 20}, {0, 40}, {0, 54}, {0, 1}}))
          .fault == PacketFault::OutOfRange);
  // Velocities that are floats.
  const auto fast = [](std::uint32_t bits) {
    return record({{0, 1},
                   {0, 1},
                   {1, 1},
                   {0, 3},
                   {0, 54},
                   {0, 1},
                   {1, 1},
                   {bits, 32},
                   {0, 48},
                   {0, 48},
                   {0, 64}});
  };
  CHECK(decoded(fast(0x42000000)).ok());  // 32 m/s
  CHECK(decoded(fast(0x7fc00000)).fault == PacketFault::NotFinite);
  CHECK(decoded(fast(0x7f800000)).fault == PacketFault::NotFinite);
  CHECK(decoded(fast(0x7f000000)).fault == PacketFault::OutOfRange);
  // More than was counted, less than was counted, and a bit after the end.
  CHECK(decoded(record(with(kResting, {{0, 1}, {0, 8}}))).fault == PacketFault::BadLength);
  CHECK(decoded(record(with(kResting, {{0, 1}}), 2)).fault == PacketFault::BadLength);
  CHECK(decoded(record(with(kResting, {{0, 1}, {1, 1}}))).fault == PacketFault::BadLength);
  Bytes stamped = record(with(kResting, {{0, 1}}));
  stamped[13] = std::byte{0x7f};
  CHECK(decoded(stamped).fault == PacketFault::OutOfRange);
}

TEST_CASE("compact: names of nothing and beyond the last index are refused", "[consensus][fault]") {
  const std::vector<SharedId> ids = {{1, 2}, {3, 4}};
  Bytes bytes;
  encode_indices(3, 65534, ids, bytes);
  CHECK(decoded(bytes).ok());
  bytes[10] = std::byte{0xff};  // first = 65535
  CHECK(decoded(bytes).fault == PacketFault::BadId);
  bytes[10] = std::byte{0};
  for (std::size_t i = 12 + 16; i < bytes.size(); ++i) bytes[i] = std::byte{0};
  CHECK(decoded(bytes).fault == PacketFault::BadId);
}

TEST_CASE("compact: a packet that ends anywhere else is refused", "[consensus][fault]") {
  const Bytes whole = everything();
  DecodedPacket packet;
  REQUIRE(decode(whole, packet).ok());
  CHECK(packet.compact.size() == 6);
  std::size_t accepted = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const CodecResult result =
        decoded(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)));
    if (result.ok()) ++accepted;
    if (!result.ok()) CHECK(result.fault == PacketFault::BadLength);
  }
  CHECK(accepted == 4);  // after each message but the last
}

TEST_CASE("compact: mutated bytes decode to values within bounds", "[consensus][fault]") {
  Dice dice(52);
  const Bytes base = everything();
  DecodedPacket packet;
  int accepted = 0;
  int refusals = 0;
  for (int round = 0; round < 100000; ++round) {
    Bytes bytes = base;
    const std::size_t mutations = 1 + dice.below(4);
    for (std::size_t i = 0; i < mutations; ++i) {
      bytes[dice.below(bytes.size())] ^= static_cast<std::byte>(1u << dice.below(8));
    }
    if (round % 4 == 1) bytes.resize(dice.below(bytes.size() + 1));
    if (!decode(bytes, packet).ok()) {
      ++refusals;
      REQUIRE(packet.compact.empty());
      continue;
    }
    ++accepted;
    std::int32_t last = -1;
    for (const CompactState& state : packet.compact) {
      const StateUpdate& s = state.update;
      REQUIRE(state.index > last);
      last = state.index;
      REQUIRE(s.pose.position.norm() < 1e7);
      REQUIRE(s.twist.linear.norm() < 1e5 * (1.0 + 1e-6));
      REQUIRE(s.twist.angular.norm() < 1e5 * (1.0 + 1e-6));
      REQUIRE(std::abs(s.pose.orientation.norm() - 1.0) < 1e-9);
      REQUIRE((s.influence >= 0.0f && s.influence <= 1.0f));
      REQUIRE((!s.flags.resting || s.twist.linear.isZero(0.0)));
    }
    for (const AnchorUpdate& anchor : packet.anchors) {
      REQUIRE(anchor.anchor_w.norm() < 1e7);
      REQUIRE(anchor.anchor_velocity.norm() < 1e5);
    }
    for (const IndexAssignment& name : packet.assignments) REQUIRE(name.id.valid());
  }
  CHECK(accepted > 10000);
  CHECK(refusals > 10000);
}

}  // namespace compact_fault_test
