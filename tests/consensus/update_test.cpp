// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/update.h"

#include <array>
#include <cmath>
#include <limits>

#include "consensus/updates.h"
#include "support/catch.h"

namespace update_test {

using namespace tandem;
using namespace tandem::consensus;
using tandem::consensus::testing::Dice;
using tandem::consensus::testing::some_act;
using tandem::consensus::testing::some_spring;
using tandem::consensus::testing::some_state;

namespace {

/// Angle between two orientations, exact for small ones too.
double angle_between(const pbd::Quat& a, const pbd::Quat& b) {
  const pbd::Quat d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

}  // namespace

TEST_CASE("codec: a state survives the round trip", "[consensus][unit]") {
  Dice dice(1);
  std::vector<StateUpdate> sent;
  for (int i = 0; i < 500; ++i) sent.push_back(some_state(dice));
  std::vector<std::byte> bytes;
  REQUIRE(encode(sent, bytes) == sent.size());
  CHECK(bytes.size() == kHeaderBytes + sent.size() * kStateBytes);

  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.states.size() == sent.size());
  CHECK(packet.springs.empty());
  CHECK(packet.leaves.empty());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const StateUpdate& a = sent[i];
    const StateUpdate& b = packet.states[i];
    CHECK(a.id == b.id);
    CHECK(a.pose.position == b.pose.position);
    CHECK(a.influence == b.influence);
    CHECK(a.stamp == b.stamp);
    CHECK(a.flags == b.flags);
    // 24 bits of mantissa, rounded: 2^-24 of each component.
    CHECK((a.twist.linear - b.twist.linear).cwiseAbs().maxCoeff() <= 50.0 * 0x1p-24);
    CHECK((a.twist.angular - b.twist.angular).cwiseAbs().maxCoeff() <= 50.0 * 0x1p-24);
    // Four roundings of 2^-31 each turn a unit quaternion by at most 2 * 2 * 2^-31 rad.
    CHECK(angle_between(a.pose.orientation, b.pose.orientation) < 2e-9);
    CHECK(std::abs(b.pose.orientation.norm() - 1.0) < 1e-15);
  }
}

TEST_CASE("codec: a spring survives the round trip bit for bit", "[consensus][unit]") {
  Dice dice(2);
  std::vector<SpringUpdate> sent;
  for (int i = 0; i < 200; ++i) sent.push_back(some_spring(dice));
  std::vector<std::byte> bytes;
  REQUIRE(encode(sent, bytes) == sent.size());
  CHECK(bytes.size() == kHeaderBytes + sent.size() * kSpringBytes);

  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.springs.size() == sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const SpringUpdate& a = sent[i];
    const SpringUpdate& b = packet.springs[i];
    CHECK(a.spring == b.spring);
    CHECK(a.revision == b.revision);
    CHECK(a.event == b.event);
    CHECK(a.body == b.body);
    CHECK(a.attachment_l == b.attachment_l);
    CHECK(a.anchor_w == b.anchor_w);
    CHECK(a.anchor_velocity == b.anchor_velocity);
    CHECK(a.stiffness == b.stiffness);
    CHECK(a.damping == b.damping);
    CHECK(a.max_force == b.max_force);
    CHECK(a.stamp == b.stamp);
  }
}

TEST_CASE("codec: an act and its receipt survive the round trip", "[consensus][unit]") {
  Dice dice(15);
  std::vector<ActUpdate> sent;
  std::vector<ActReceipt> receipts;
  for (int i = 0; i < 200; ++i) {
    sent.push_back(some_act(dice));
    receipts.push_back({.actor = dice.bits() | 1,
                        .number = static_cast<std::uint32_t>(dice.bits()),
                        .body = sent.back().body,
                        .name = dice.bits(),
                        .stamp = sent.back().stamp});
  }
  std::vector<std::byte> bytes;
  REQUIRE(encode(sent, bytes) == sent.size());
  CHECK(bytes.size() == kHeaderBytes + sent.size() * kActBytes);
  REQUIRE(encode(receipts, bytes) == receipts.size());
  CHECK(bytes.size() == 2 * kHeaderBytes + sent.size() * (kActBytes + kActReceiptBytes));

  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.acts.size() == sent.size());
  REQUIRE(packet.receipts.size() == receipts.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const ActUpdate& a = sent[i];
    const ActUpdate& b = packet.acts[i];
    CHECK(a.number == b.number);
    CHECK(a.body == b.body);
    CHECK(a.name == b.name);
    CHECK(a.impulse == b.impulse);
    CHECK(a.angular_impulse == b.angular_impulse);
    REQUIRE(a.pose.has_value() == b.pose.has_value());
    if (a.pose) {
      CHECK(a.pose->position == b.pose->position);
      CHECK(a.pose->orientation.angularDistance(b.pose->orientation) < 2e-9);
    }
    REQUIRE(a.twist.has_value() == b.twist.has_value());
    if (a.twist) {
      CHECK(a.twist->linear == b.twist->linear);
      CHECK(a.twist->angular == b.twist->angular);
    }
    CHECK(a.stamp == b.stamp);
    CHECK(receipts[i].actor == packet.receipts[i].actor);
    CHECK(receipts[i].number == packet.receipts[i].number);
    CHECK(receipts[i].body == packet.receipts[i].body);
    CHECK(receipts[i].name == packet.receipts[i].name);
    CHECK(receipts[i].stamp == packet.receipts[i].stamp);
  }
}

TEST_CASE("codec: a message has the documented bytes on every machine", "[consensus][golden]") {
  StateUpdate update;
  update.id = {0x0102030405060708, 0x090a0b0c0d0e0f10};
  update.pose.position = {1.0, -2.0, 0.5};
  update.twist.linear = {1.0, 0.0, 0.0};
  update.pose.orientation = pbd::Quat(0.0, 1.0, 0.0, 0.0);
  update.twist.angular = {0.0, 0.0, -1.0};
  update.influence = 0.5f;
  update.stamp = -2;
  update.flags.held = true;
  update.flags.teleported = true;
  std::vector<std::byte> bytes;
  REQUIRE(encode(std::span(&update, 1), bytes) == 1);

  // Written by hand from the IEEE 754 forms, least significant byte first.
  const std::array<unsigned, kHeaderBytes + kStateBytes> expected = {
      0x54, 0x43, 2,    1,    1,    0,  // "TC", version, kind, count
      8,    7,    6,    5,    4,    3,    2,    1,    16, 15, 14,   13,
      12,   11,   10,   9,                                              // id, two 64-bit halves
      0,    0,    0,    0,    0,    0,    0xf0, 0x3f,                   // x = 1
      0,    0,    0,    0,    0,    0,    0,    0xc0,                   // y = -2
      0,    0,    0,    0,    0,    0,    0xe0, 0x3f,                   // z = 0.5
      0,    0,    0x80, 0x3f, 0,    0,    0,    0,    0,  0,  0,    0,  // v
      0,    0,    0,    0,    0,    0,    0,    0x40, 0,  0,  0,    0,
      0,    0,    0,    0,                                                 // q: w, x = 2^30, y, z
      0,    0,    0,    0,    0,    0,    0,    0,    0,  0,  0x80, 0xbf,  // omega
      0,    0,    0,    0x3f,                                              // influence = 0.5
      0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,                      // stamp = -2
      0x0a};                                                               // held, teleported
  REQUIRE(bytes.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO("byte " << i);
    CHECK(std::to_integer<unsigned>(bytes[i]) == expected[i]);
  }
}

TEST_CASE("codec: a packet carries messages of several kinds in any order", "[consensus][unit]") {
  Dice dice(3);
  const std::array<StateUpdate, 3> states = {some_state(dice), some_state(dice), some_state(dice)};
  const SpringUpdate spring = some_spring(dice);
  std::vector<std::byte> bytes;
  encode(std::span(&spring, 1), bytes);
  encode(std::span(states).first(1), bytes);
  encode(Leave{42}, bytes);
  encode(std::span(states).subspan(1), bytes);

  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.states.size() == 3);
  CHECK(packet.states[2].id == states[2].id);
  REQUIRE(packet.springs.size() == 1);
  CHECK(packet.springs[0].spring == spring.spring);
  REQUIRE(packet.leaves.size() == 1);
  CHECK(packet.leaves[0].stamp == 42);
}

TEST_CASE("codec: nothing to say takes no bytes", "[consensus][unit]") {
  std::vector<std::byte> bytes;
  CHECK(encode(std::span<const StateUpdate>(), bytes) == 0);
  CHECK(encode(std::span<const SpringUpdate>(), bytes) == 0);
  CHECK(bytes.empty());
}

TEST_CASE("codec: the largest packets are as large as promised", "[consensus][unit]") {
  Dice dice(4);
  const std::vector<StateUpdate> states(kMaxStatesPerPacket, some_state(dice));
  std::vector<std::byte> bytes;
  encode(states, bytes);
  DecodedPacket packet;
  CHECK(bytes.size() <= kMaxPacketBytes);
  CHECK(bytes.size() + kStateBytes > kMaxPacketBytes);
  CHECK(decode(bytes, packet).ok());

  const std::vector<SpringUpdate> springs(kMaxSpringsPerPacket, some_spring(dice));
  bytes.clear();
  encode(springs, bytes);
  CHECK(bytes.size() <= kMaxPacketBytes);
  CHECK(bytes.size() + kSpringBytes > kMaxPacketBytes);
  CHECK(decode(bytes, packet).ok());
}

TEST_CASE("codec: more records than a message holds become several messages", "[consensus][unit]") {
  Dice dice(5);
  const std::vector<SpringUpdate> springs(2 * kMaxRecords + 1, some_spring(dice));
  std::vector<std::byte> bytes;
  CHECK(encode(springs, bytes) == springs.size());
  CHECK(bytes.size() == 3 * kHeaderBytes + springs.size() * kSpringBytes);
}

TEST_CASE("codec: a sender leaves out updates that its peers would refuse", "[consensus][unit]") {
  Dice dice(6);
  std::array<StateUpdate, 3> states = {some_state(dice), some_state(dice), some_state(dice)};
  states[1].pose.position.y() = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::byte> bytes;
  CHECK(encode(states, bytes) == 2);
  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.states.size() == 2);
  CHECK(packet.states[1].id == states[2].id);

  bytes.clear();
  CHECK(encode(std::span(states).subspan(1, 1), bytes) == 0);
  CHECK(bytes.empty());
}

TEST_CASE("codec: sender and receiver agree about values at the edge of a range",
          "[consensus][unit]") {
  // The nearest 32-bit float to this speed is the limit itself, which is refused.
  Dice dice(7);
  StateUpdate update = some_state(dice);
  update.twist.linear = {std::nextafter(kMaxLinearSpeed, 0.0), 0.0, 0.0};
  std::vector<std::byte> bytes;
  CHECK(encode(std::span(&update, 1), bytes) == 0);
  update.twist.linear = {std::nextafter(1e5f, 0.0f), 0.0, 0.0};
  CHECK(encode(std::span(&update, 1), bytes) == 1);
  DecodedPacket packet;
  CHECK(decode(bytes, packet).ok());

  // Norms around the limit of 1e-3, closer than the 2^-30 of the wire can tell.
  int accepted = 0;
  for (int i = 0; i < 1000; ++i) {
    update = some_state(dice);
    update.pose.orientation.coeffs() *= 1.001 + dice.uniform(-2e-9, 2e-9);
    bytes.clear();
    if (encode(std::span(&update, 1), bytes) == 0) continue;
    ++accepted;
    CHECK(decode(bytes, packet).ok());
  }
  CHECK(accepted > 100);
  CHECK(accepted < 900);
}

TEST_CASE("codec: decoding into a used packet allocates nothing", "[consensus][unit]") {
  Dice dice(8);
  const std::vector<StateUpdate> states(100, some_state(dice));
  std::vector<std::byte> bytes;
  encode(states, bytes);
  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  const StateUpdate* const place = packet.states.data();
  const std::size_t capacity = packet.states.capacity();
  for (int i = 0; i < 10; ++i) REQUIRE(decode(bytes, packet).ok());
  CHECK(packet.states.data() == place);
  CHECK(packet.states.capacity() == capacity);
  CHECK(packet.states.size() == 100);
}

}  // namespace update_test
