// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "consensus/updates.h"
#include "support/catch.h"
#include "tandem/consensus/update.h"

namespace update_fault_test {

using namespace tandem;
using namespace tandem::consensus;
using tandem::consensus::testing::Dice;
using tandem::consensus::testing::some_act;
using tandem::consensus::testing::some_spring;
using tandem::consensus::testing::some_state;

namespace {

using Bytes = std::vector<std::byte>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// Offsets of fields within a record, from the documented layout.
constexpr std::size_t kStatePosition = 16;
constexpr std::size_t kStateVelocity = 40;
constexpr std::size_t kStateOrientation = 52;
constexpr std::size_t kStateAngular = 68;
constexpr std::size_t kStateInfluence = 80;
constexpr std::size_t kStateStamp = 84;
constexpr std::size_t kStateFlags = 92;
constexpr std::size_t kSpringEvent = 8;
constexpr std::size_t kSpringBody = 9;
constexpr std::size_t kSpringStiffness = 97;
constexpr std::size_t kActBody = 4;
constexpr std::size_t kActSays = 28;
constexpr std::size_t kActImpulse = 29;
constexpr std::size_t kActAngular = 53;
constexpr std::size_t kActPosition = 77;
constexpr std::size_t kActOrientation = 101;
constexpr std::size_t kActVelocity = 117;
constexpr std::size_t kActStamp = 165;

Bytes two_states() {
  Dice dice(11);
  const std::array<StateUpdate, 2> states = {some_state(dice), some_state(dice)};
  Bytes bytes;
  encode(states, bytes);
  return bytes;
}

Bytes one_spring() {
  Dice dice(12);
  const SpringUpdate spring = some_spring(dice);
  Bytes bytes;
  encode(std::span(&spring, 1), bytes);
  return bytes;
}

/// With pose and twist.
Bytes one_act() {
  Dice dice(16);
  ActUpdate act = some_act(dice);
  act.pose = pbd::Pose{dice.vec3(1e3), dice.rotation(3.0)};
  act.twist = pbd::Twist{dice.vec3(50.0), dice.vec3(50.0)};
  Bytes bytes;
  encode(std::span(&act, 1), bytes);
  return bytes;
}

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
  // The tests run on little-endian machines only, which is checked here.
  const std::uint16_t one = 1;
  REQUIRE(*reinterpret_cast<const unsigned char*>(&one) == 1);
  const std::byte* const raw = reinterpret_cast<const std::byte*>(&value);
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes.at(at + i) = raw[i];
}

/// Decode into a packet that holds something already: a fault must leave nothing behind.
CodecResult refused(const Bytes& bytes) {
  DecodedPacket packet;
  packet.states.resize(3);
  packet.springs.resize(3);
  packet.leaves.resize(3);
  packet.acts.resize(3);
  packet.receipts.resize(3);
  const CodecResult result = decode(bytes, packet);
  CHECK_FALSE(result.ok());
  CHECK(packet.states.empty());
  CHECK(packet.springs.empty());
  CHECK(packet.leaves.empty());
  CHECK(packet.acts.empty());
  CHECK(packet.receipts.empty());
  return result;
}

/// Overwrite a field of the second state.
template <class T>
CodecResult with_second(std::size_t field, T value) {
  Bytes bytes = two_states();
  put(bytes, kHeaderBytes + kStateBytes + field, value);
  return refused(bytes);
}

template <class T>
CodecResult with_spring(std::size_t field, T value) {
  Bytes bytes = one_spring();
  put(bytes, kHeaderBytes + field, value);
  return refused(bytes);
}

template <class T>
CodecResult with_act(std::size_t field, T value) {
  Bytes bytes = one_act();
  put(bytes, kHeaderBytes + field, value);
  return refused(bytes);
}

}  // namespace

TEST_CASE("codec: a truncated packet is refused at every length", "[consensus][fault]") {
  const Bytes whole = two_states();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    INFO(length);
    CHECK(
        refused(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length))).fault ==
        PacketFault::BadLength);
  }
}

TEST_CASE("codec: bytes after the last message are refused", "[consensus][fault]") {
  Bytes bytes = two_states();
  const std::size_t end = bytes.size();
  bytes.push_back(std::byte{0x54});
  const CodecResult result = refused(bytes);
  CHECK(result.fault == PacketFault::BadLength);
  CHECK(result.offset == end);
}

TEST_CASE("codec: a bad header is refused by name", "[consensus][fault]") {
  Bytes bytes = two_states();
  SECTION("magic") {
    bytes[1] ^= std::byte{1};
    CHECK(refused(bytes).fault == PacketFault::BadMagic);
  }
  SECTION("another version") {
    for (const unsigned version : {0u, 1u, 3u, 255u}) {
      bytes[2] = static_cast<std::byte>(version);
      CHECK(refused(bytes).fault == PacketFault::BadVersion);
    }
  }
  SECTION("kind") {
    for (const unsigned kind : {0u, 12u, 255u}) {
      bytes[3] = static_cast<std::byte>(kind);
      CHECK(refused(bytes).fault == PacketFault::UnknownKind);
    }
  }
  SECTION("count") {
    for (const unsigned count : {0u, 1025u, 65535u}) {
      put(bytes, 4, static_cast<std::uint16_t>(count));
      CHECK(refused(bytes).fault == PacketFault::BadCount);
    }
    put(bytes, 4, std::uint16_t{1024});
    CHECK(refused(bytes).fault == PacketFault::BadLength);
    put(bytes, 4, std::uint16_t{1});  // the second record is then no message
    CHECK_FALSE(refused(bytes).ok());
  }
}

TEST_CASE("codec: a packet above the limit is refused unread", "[consensus][fault]") {
  Dice dice(13);
  const std::vector<StateUpdate> states(kMaxStatesPerPacket + 1, some_state(dice));
  Bytes bytes;
  encode(states, bytes);
  CHECK(refused(bytes).fault == PacketFault::TooLong);
}

TEST_CASE("codec: numbers that are not finite are refused", "[consensus][fault]") {
  for (const double bad : {kNan, kInf, -kInf}) {
    const float bad32 = static_cast<float>(bad);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(with_second(kStatePosition + 8 * axis, bad).fault == PacketFault::NotFinite);
      CHECK(with_second(kStateVelocity + 4 * axis, bad32).fault == PacketFault::NotFinite);
      CHECK(with_second(kStateAngular + 4 * axis, bad32).fault == PacketFault::NotFinite);
    }
    CHECK(with_second(kStateInfluence, bad32).fault == PacketFault::NotFinite);
    // Nine components, stiffness, damping, maximal force: every f64 of a spring.
    for (std::size_t field = 25; field < 121; field += 8) {
      CHECK(with_spring(field, bad).fault == PacketFault::NotFinite);
    }
  }
}

TEST_CASE("codec: values out of their range are refused", "[consensus][fault]") {
  CHECK(with_second(kStatePosition, 1e7).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStatePosition, -1e300).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStateVelocity, 1e5f).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStateVelocity, -3e38f).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStateAngular, 1e5f).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStateInfluence, -0.01f).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStateInfluence, 1.0001f).fault == PacketFault::OutOfRange);
  const SessionTime first = std::numeric_limits<SessionTime>::min();
  const SessionTime last = std::numeric_limits<SessionTime>::max();
  CHECK(with_second(kStateStamp, first).fault == PacketFault::OutOfRange);
  CHECK(with_second(kStateStamp, last).fault == PacketFault::OutOfRange);
  for (std::size_t field = kSpringStiffness; field < kSpringStiffness + 24; field += 8) {
    CHECK(with_spring(field, -1.0).fault == PacketFault::OutOfRange);
    CHECK(with_spring(field, 1e12).fault == PacketFault::OutOfRange);
  }
}

TEST_CASE("codec: an orientation far from unit norm is refused", "[consensus][fault]") {
  const auto with_norm = [](double norm) {
    Bytes bytes = two_states();
    const std::size_t at = kHeaderBytes + kStateOrientation;
    for (std::size_t i = 0; i < 16; i += 4) put(bytes, at + i, std::int32_t{0});
    put(bytes, at + 4, static_cast<std::int32_t>(norm * 0x1p30));
    DecodedPacket packet;
    return decode(bytes, packet).fault;
  };
  CHECK(with_norm(1.0) == PacketFault::None);
  CHECK(with_norm(0.9991) == PacketFault::None);
  CHECK(with_norm(-1.0009) == PacketFault::None);
  CHECK(with_norm(0.0) == PacketFault::OutOfRange);
  CHECK(with_norm(0.9989) == PacketFault::OutOfRange);
  CHECK(with_norm(1.0011) == PacketFault::OutOfRange);
  CHECK(with_norm(-1.999) == PacketFault::OutOfRange);
}

TEST_CASE("codec: codes and ids that mean nothing are refused", "[consensus][fault]") {
  CHECK(with_second(kStateFlags, std::uint8_t{0x40}).fault == PacketFault::BadCode);
  CHECK(with_second(kStateFlags, std::uint8_t{0x80}).fault == PacketFault::BadCode);
  CHECK(with_spring(kSpringEvent, std::uint8_t{0}).fault == PacketFault::BadCode);
  CHECK(with_spring(kSpringEvent, std::uint8_t{4}).fault == PacketFault::BadCode);
  Bytes bytes = one_spring();
  put(bytes, kHeaderBytes + kSpringBody, std::uint64_t{0});
  put(bytes, kHeaderBytes + kSpringBody + 8, std::uint64_t{0});
  CHECK(refused(bytes).fault == PacketFault::BadId);
}

TEST_CASE("codec: an act that cannot be is refused", "[consensus][fault]") {
  CHECK(with_act(kActSays, std::uint8_t{4}).fault == PacketFault::BadCode);
  CHECK(with_act(kActSays, std::uint8_t{255}).fault == PacketFault::BadCode);
  for (const double bad : {kNan, kInf, -kInf}) {
    for (std::size_t axis = 0; axis < 24; axis += 8) {
      CHECK(with_act(kActImpulse + axis, bad).fault == PacketFault::NotFinite);
      CHECK(with_act(kActAngular + axis, bad).fault == PacketFault::NotFinite);
      CHECK(with_act(kActPosition + axis, bad).fault == PacketFault::NotFinite);
      CHECK(with_act(kActVelocity + axis, bad).fault == PacketFault::NotFinite);
      CHECK(with_act(kActVelocity + 24 + axis, bad).fault == PacketFault::NotFinite);
    }
  }
  CHECK(with_act(kActImpulse, 1e12).fault == PacketFault::OutOfRange);
  CHECK(with_act(kActAngular, -1e300).fault == PacketFault::OutOfRange);
  CHECK(with_act(kActPosition, 1e7).fault == PacketFault::OutOfRange);
  CHECK(with_act(kActOrientation, std::int32_t{0x7fffffff}).fault == PacketFault::OutOfRange);
  CHECK(with_act(kActVelocity, 1e5).fault == PacketFault::OutOfRange);
  CHECK(with_act(kActVelocity + 24, 1e5).fault == PacketFault::OutOfRange);
  CHECK(with_act(kActStamp, std::numeric_limits<SessionTime>::max()).fault ==
        PacketFault::OutOfRange);
  Bytes bytes = one_act();
  put(bytes, kHeaderBytes + kActBody, std::uint64_t{0});
  put(bytes, kHeaderBytes + kActBody + 8, std::uint64_t{0});
  CHECK(refused(bytes).fault == PacketFault::BadId);
  const ActReceipt receipt{.actor = 3, .body = SharedId::from_name("a body"), .stamp = 5};
  bytes.clear();
  encode(std::span(&receipt, 1), bytes);
  put(bytes, kHeaderBytes, std::uint64_t{0});
  CHECK(refused(bytes).fault == PacketFault::BadId);
}

TEST_CASE("codec: a refusal says where and why", "[consensus][fault]") {
  const CodecResult result = with_second(kStateInfluence, 2.0f);
  CHECK(result.offset == kHeaderBytes + kStateBytes);
  CHECK(result.reason() == "byte 99: influence: must be 0 to 1");
  CHECK(CodecResult{}.reason().empty());
}

TEST_CASE("codec: a fault in a later message takes back the earlier ones", "[consensus][fault]") {
  Bytes bytes = one_spring();
  const std::size_t second = bytes.size();
  const Bytes states = two_states();
  bytes.insert(bytes.end(), states.begin(), states.end());
  bytes[second + 2] = std::byte{9};
  const CodecResult result = refused(bytes);
  CHECK(result.fault == PacketFault::BadVersion);
  CHECK(result.offset == second);
}

TEST_CASE("codec: random and mutated bytes decode to values within bounds", "[consensus][fault]") {
  Dice dice(14);
  Bytes base = two_states();
  const Bytes spring = one_spring();
  base.insert(base.end(), spring.begin(), spring.end());
  encode(Leave{1}, base);
  const Bytes act = one_act();
  base.insert(base.end(), act.begin(), act.end());
  const ActReceipt receipt{.actor = 3, .body = SharedId::from_name("a body"), .stamp = 5};
  encode(std::span(&receipt, 1), base);

  DecodedPacket packet;
  int accepted = 0;
  int refusals = 0;
  for (int round = 0; round < 200000; ++round) {
    Bytes bytes;
    if (round % 4 == 0) {  // noise, sometimes behind a true header
      bytes.resize(dice.below(400));
      for (std::byte& b : bytes) b = static_cast<std::byte>(dice.bits());
      if (round % 8 == 0)
        std::copy_n(base.begin(), std::min<std::size_t>(bytes.size(), 4), bytes.begin());
    } else {
      bytes = base;
      const std::size_t mutations = 1 + dice.below(4);
      for (std::size_t i = 0; i < mutations; ++i) {
        bytes[dice.below(bytes.size())] ^= static_cast<std::byte>(1u << dice.below(8));
      }
      if (round % 4 == 1) bytes.resize(dice.below(bytes.size() + 1));
      if (round % 4 == 2) bytes.insert(bytes.end(), base.begin(), base.end());
    }
    const CodecResult result = decode(bytes, packet);
    if (!result.ok()) {
      ++refusals;
      REQUIRE(result.offset <= bytes.size());
      REQUIRE_FALSE(result.reason().empty());
      REQUIRE((packet.states.empty() && packet.springs.empty() && packet.leaves.empty()));
      continue;
    }
    ++accepted;
    for (const StateUpdate& s : packet.states) {
      REQUIRE(s.pose.position.norm() < 1e7);
      REQUIRE(s.twist.linear.norm() < 1e5 * (1.0 + 1e-6));
      REQUIRE(s.twist.angular.norm() < 1e5 * (1.0 + 1e-6));
      REQUIRE(std::abs(s.pose.orientation.norm() - 1.0) < 1e-14);
      REQUIRE((s.influence >= 0.0f && s.influence <= 1.0f));
      REQUIRE(s.id.valid());
    }
    for (const SpringUpdate& s : packet.springs) {
      REQUIRE((s.attachment_l.norm() < 1e7 && s.anchor_w.norm() < 1e7));
      REQUIRE(s.anchor_velocity.norm() < 1e5);
      REQUIRE((s.stiffness >= 0.0 && s.stiffness < 1e12));
      REQUIRE((s.damping >= 0.0 && s.damping < 1e12));
      REQUIRE((s.max_force >= 0.0 && s.max_force < 1e12));
    }
    for (const ActUpdate& a : packet.acts) {
      REQUIRE((a.impulse.norm() < 1e12 && a.angular_impulse.norm() < 1e12));
      if (a.pose) REQUIRE(a.pose->position.norm() < 1e7);
      if (a.pose) REQUIRE(std::abs(a.pose->orientation.norm() - 1.0) < 1e-14);
      if (a.twist) REQUIRE((a.twist->linear.norm() < 1e5 && a.twist->angular.norm() < 1e5));
      REQUIRE(a.body.valid());
    }
    for (const ActReceipt& r : packet.receipts) REQUIRE((r.actor != 0 && r.body.valid()));
  }
  // Both happen often, or the loop tests nothing.
  CHECK(accepted > 10000);
  CHECK(refusals > 50000);
}

}  // namespace update_fault_test
