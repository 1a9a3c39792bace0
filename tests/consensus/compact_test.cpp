// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/compact.h"

#include <array>
#include <cmath>

#include "consensus/updates.h"
#include "support/catch.h"

namespace compact_test {

using namespace tandem;
using namespace tandem::consensus;
using tandem::consensus::testing::Dice;
using tandem::consensus::testing::some_spring;
using tandem::consensus::testing::some_state;

namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kNoLimit = 60 * 1024;

double angle_between(const pbd::Quat& a, const pbd::Quat& b) {
  const pbd::Quat d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

/// As bodies in a scene are: within 100 m, at usual speeds, of one time.
StateUpdate usual_state(Dice& dice) {
  StateUpdate update = some_state(dice);
  update.pose.position = dice.vec3(15.0);
  update.twist.linear = dice.vec3(10.0);
  update.twist.angular = dice.vec3(15.0);
  update.influence = 0.08f;
  update.stamp = 5'000'000'000;
  update.flags = {.in_contact = dice.below(2) == 0};
  return update;
}

StateUpdate resting_state(Dice& dice) {
  StateUpdate update = usual_state(dice);
  update.twist = {};
  update.flags = {.in_contact = true, .resting = true};
  return update;
}

/// The decoded state, which must also be the sender's.
std::vector<CompactState> round_trip(std::span<const IndexedState> states) {
  std::vector<IndexedState> sent(states.begin(), states.end());
  Bytes bytes;
  REQUIRE(encode_compact(sent, 7, kNoLimit, bytes) == sent.size());
  DecodedPacket packet;
  const CodecResult result = decode(bytes, packet);
  INFO(result.reason());
  REQUIRE(result.ok());
  REQUIRE(packet.compact.size() == states.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const StateUpdate& said = sent[i].update;
    const StateUpdate& heard = packet.compact[i].update;
    CHECK(said.rounded);
    CHECK(said.pose.position == heard.pose.position);
    if (said.oriented) {
      CHECK(said.pose.orientation.coeffs() == heard.pose.orientation.coeffs());
    }
    CHECK(said.twist.linear == heard.twist.linear);
    CHECK(said.twist.angular == heard.twist.angular);
    CHECK(said.influence == heard.influence);
  }
  return packet.compact;
}

CompactState round_trip(const StateUpdate& update) {
  const IndexedState state{3, update};
  return round_trip(std::span(&state, 1)).front();
}

// Half a quantum, and what adding up in floating point may add to it.
constexpr double kHalfPosition = 0.5 / 4096.0 * (1.0 + 1e-9);
constexpr double kHalfSpeed = 0.5 / 1024.0 * (1.0 + 1e-9);
// The angle of two unit quaternions is twice that of two vectors. The three components are off by
// up to d = sqrt(1/2) / 16383 / 2 each; the largest, at least 1/2, by up to 3 d in first order.
const double kMaxAngle = 2.0 * std::sqrt(3.0 + 9.0) * (std::sqrt(0.5) / 16383.0 / 2.0) * 1.001;

}  // namespace

TEST_CASE("compact: a state comes back within half a quantum of everything", "[consensus][unit]") {
  Dice dice(41);
  std::vector<IndexedState> sent;
  std::uint32_t index = 0;
  for (int i = 0; i < 1000; ++i) {
    StateUpdate update = usual_state(dice);
    update.pose.position = dice.vec3(i % 2 == 0 ? 10.0 : 1000.0);  // in one cell, and in many
    update.influence = static_cast<float>(dice.uniform(0.0, 1.0));
    const std::uint64_t bits = dice.bits();
    update.flags = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0,
                    (bits & 16) != 0};
    sent.push_back({static_cast<std::uint16_t>(index), update});
    index += 1 + static_cast<std::uint32_t>(dice.below(i % 3 == 0 ? 100 : 20));
  }
  REQUIRE(index < 65536);
  const std::vector<CompactState> got = round_trip(sent);
  double largest_angle = 0.0;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const StateUpdate& a = sent[i].update;
    const StateUpdate& b = got[i].update;
    CHECK(got[i].index == sent[i].index);
    CHECK(got[i].table == 7);
    CHECK_FALSE(b.id.valid());
    CHECK(b.rounded);
    CHECK(b.oriented);
    CHECK(b.stamp == a.stamp);
    CHECK(b.flags == a.flags);
    CHECK((b.pose.position - a.pose.position).cwiseAbs().maxCoeff() <= kHalfPosition);
    CHECK((b.twist.linear - a.twist.linear).cwiseAbs().maxCoeff() <= kHalfSpeed);
    CHECK((b.twist.angular - a.twist.angular).cwiseAbs().maxCoeff() <= kHalfSpeed);
    CHECK(std::abs(b.influence - a.influence) <= 0.5f / 65535.0f * 1.001f);
    const double angle = angle_between(a.pose.orientation, b.pose.orientation);
    largest_angle = std::max(largest_angle, angle);
    CHECK(angle <= kMaxAngle);
    CHECK(std::abs(b.pose.orientation.norm() - 1.0) < 1e-14);
  }
  CHECK(largest_angle > 0.2 * kMaxAngle);  // the bound is not idle
}

TEST_CASE("compact: values on the lattice are unchanged", "[consensus][unit]") {
  Dice dice(42);
  for (int i = 0; i < 300; ++i) {
    const StateUpdate once = round_trip(usual_state(dice)).update;
    const StateUpdate twice = round_trip(once).update;
    CHECK(twice.pose.position == once.pose.position);
    CHECK(twice.twist.linear == once.twist.linear);
    CHECK(twice.twist.angular == once.twist.angular);
    CHECK(twice.influence == once.influence);
    CHECK(angle_between(once.pose.orientation, twice.pose.orientation) < 1e-9);
  }
  // Bodies that lie along the axes and owners are said exactly.
  StateUpdate update = usual_state(dice);
  update.pose = {{0.5, -3.25, 31.0}, pbd::Quat(0.0, 0.0, -1.0, 0.0)};
  update.influence = 1.0f;
  const StateUpdate out = round_trip(update).update;
  CHECK(out.pose.position == update.pose.position);
  CHECK(angle_between(out.pose.orientation, update.pose.orientation) == 0.0);
  CHECK(out.influence == 1.0f);
}

TEST_CASE("compact: far from the origin, at borders of cells and fast, nothing is lost",
          "[consensus][unit]") {
  Dice dice(43);
  std::vector<IndexedState> sent;
  const double border = 32.0;
  for (const double x : {border, -border, border - 1.0 / 4096.0, border - 1e-5, -border - 1e-5,
                         3.0 * border, 5e6 + 0.123, -5.7e6, 9.4e6}) {
    StateUpdate update = usual_state(dice);
    update.pose.position = {x, -x / 3.0, 1.0};
    sent.push_back({static_cast<std::uint16_t>(sent.size()), update});
  }
  for (const double v : {63.9, 63.99999, 64.0, 65.0, -64.1, 5e4}) {
    StateUpdate update = usual_state(dice);
    update.twist.linear = {v, 0.1, 0.2};
    sent.push_back({static_cast<std::uint16_t>(sent.size()), update});
    update.twist.linear = {1.0, 2.0, 3.0};
    update.twist.angular = {0.3, 0.5 * v, 0.4};
    sent.push_back({static_cast<std::uint16_t>(sent.size()), update});
  }
  const std::vector<CompactState> got = round_trip(sent);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    INFO(i);
    const StateUpdate& a = sent[i].update;
    const StateUpdate& b = got[i].update;
    CHECK((b.pose.position - a.pose.position).cwiseAbs().maxCoeff() <= kHalfPosition);
    // Half a quantum, or a float's rounding where it is larger.
    for (const auto& [v, w] :
         {std::pair(a.twist.linear, b.twist.linear), std::pair(a.twist.angular, b.twist.angular)}) {
      CHECK((v - w).cwiseAbs().maxCoeff() <= std::max(kHalfSpeed, 0x1p-24 * v.norm()));
    }
  }
}

TEST_CASE("compact: a moving body takes 28 bytes in a batch, a resting one 15", "[consensus]") {
  Dice dice(44);
  constexpr std::size_t kDatagram = 1154;  // bytes for states over UDP
  const auto bytes_each = [&](auto&& make, std::size_t gap) {
    std::vector<IndexedState> states;
    for (std::size_t i = 0; i < 300; ++i) {
      states.push_back({static_cast<std::uint16_t>(gap * i + 5), make(dice)});
    }
    Bytes bytes;
    const std::size_t count = encode_compact(states, 7, kDatagram, bytes);
    CHECK(bytes.size() <= kDatagram);
    CHECK(bytes.size() + 53 > kDatagram);  // no record is longer
    DecodedPacket packet;
    REQUIRE(decode(bytes, packet).ok());
    CHECK(packet.compact.size() == count);
    return static_cast<double>(bytes.size()) / static_cast<double>(count);
  };
  for (const std::size_t gap : {1, 7}) {
    CHECK(bytes_each(usual_state, gap) <= 28.0);
    CHECK(bytes_each(resting_state, gap) <= 15.0);
  }
  const auto plain_sphere = [](Dice& d) {
    StateUpdate update = usual_state(d);
    update.oriented = false;
    return update;
  };
  // 47 bits less.
  CHECK(bytes_each(plain_sphere, 1) < bytes_each(usual_state, 1) - 5.5);
}

TEST_CASE("compact: fields that a body does not need are not written", "[consensus][unit]") {
  Dice dice(45);
  StateUpdate update = resting_state(dice);
  update.twist.linear = {0.003, 0.0, 0.0};
  CHECK(round_trip(update).update.twist.linear.isZero(0.0));
  update = usual_state(dice);
  update.oriented = false;
  const StateUpdate out = round_trip(update).update;
  CHECK_FALSE(out.oriented);
  CHECK((out.twist.angular - update.twist.angular).cwiseAbs().maxCoeff() <= kHalfSpeed);
}

TEST_CASE("compact: a packet continues where a full one stopped", "[consensus][unit]") {
  Dice dice(46);
  std::vector<IndexedState> states;
  for (std::uint16_t i = 0; i < 200; ++i) states.push_back({i, usual_state(dice)});
  states[50].update.pose.position.x() = 2e7;  // refused by all: it is left out
  std::span<IndexedState> rest(states);
  std::vector<std::uint16_t> got;
  DecodedPacket packet;
  while (!rest.empty()) {
    Bytes bytes;
    const std::size_t done = encode_compact(rest, 7, 502, bytes);
    REQUIRE(done > 0);
    REQUIRE(bytes.size() <= 502);
    REQUIRE(decode(bytes, packet).ok());
    for (const CompactState& state : packet.compact) got.push_back(state.index);
    rest = rest.subspan(done);
  }
  REQUIRE(got.size() == 199);
  for (std::size_t i = 0; i < got.size(); ++i) CHECK(got[i] == (i < 50 ? i : i + 1));
  Bytes none;
  CHECK(encode_compact(states, 7, 20, none) == 0);
  CHECK(none.empty());
}

TEST_CASE("compact: names, requests and signs of life survive the round trip", "[consensus]") {
  Dice dice(47);
  std::vector<SharedId> ids;
  for (int i = 0; i < 50; ++i) ids.push_back({dice.bits(), dice.bits() | 1});
  Bytes bytes;
  encode_indices(9, 65486, ids, bytes);
  encode(IndicesWanted{77}, bytes);
  encode(Alive{-123}, bytes);
  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.assignments.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) {
    CHECK(packet.assignments[i].table == 9);
    CHECK(packet.assignments[i].index == 65486 + i);
    CHECK(packet.assignments[i].id == ids[i]);
  }
  REQUIRE(packet.indices_wanted.size() == 1);
  CHECK(packet.indices_wanted[0].table == 77);
  REQUIRE(packet.alive.size() == 1);
  CHECK(packet.alive[0].stamp == -123);
}

TEST_CASE("compact: anchors come back within half a quantum, others are named", "[consensus]") {
  Dice dice(48);
  std::vector<SpringUpdate> springs;
  for (int i = 0; i < 20; ++i) {
    springs.push_back(some_spring(dice));
    springs.back().stamp = 1'000'000'000 + 20'000'000 * i;
  }
  springs[4].anchor_w.x() = 4e4;
  springs[5].anchor_velocity.y() = -128.0;
  springs[6].stamp = -1'000'000'000;
  Bytes bytes;
  std::vector<SpringUpdate> others;
  REQUIRE(encode_anchors(springs, 4096, others, bytes) == 20);
  REQUIRE(others.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) CHECK(others[i].spring == springs[4 + i].spring);
  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.anchors.size() == 17);
  std::size_t next = 0;
  for (std::size_t i = 0; i < springs.size(); ++i) {
    if (i >= 4 && i <= 6) continue;
    const AnchorUpdate& anchor = packet.anchors[next++];
    CHECK(anchor.spring == springs[i].spring);
    CHECK((anchor.anchor_w - springs[i].anchor_w).cwiseAbs().maxCoeff() <= 0.5 / 65536.0 + 1e-12);
    CHECK((anchor.anchor_velocity - springs[i].anchor_velocity).cwiseAbs().maxCoeff() <=
          0.5 / 256.0 + 1e-12);
    CHECK(std::abs(anchor.stamp - springs[i].stamp) <= 8192);
  }
}

TEST_CASE("compact: anchors are cut where the packet ends, and none is lost", "[consensus]") {
  Dice dice(49);
  std::vector<SpringUpdate> springs;
  for (int i = 0; i < 30; ++i) springs.push_back(some_spring(dice));
  for (SpringUpdate& spring : springs) spring.stamp = 1'000'000'000;
  springs[7].anchor_w.x() = 4e4;
  constexpr std::size_t kBefore = 5;     // bytes in the packet already
  constexpr std::size_t kOne = 14 + 24;  // header, stamp, one anchor
  for (const std::size_t room : {kOne, kOne + 1, 2 * kOne, std::size_t{502}, std::size_t{4096}}) {
    INFO("room " << room);
    std::vector<std::uint32_t> told;
    std::vector<SpringUpdate> others;
    for (std::span<const SpringUpdate> left(springs); !left.empty();) {
      Bytes bytes(kBefore);
      const std::size_t count = encode_anchors(left, kBefore + room, others, bytes);
      REQUIRE(count > 0);
      REQUIRE(bytes.size() <= kBefore + room);
      // Another one would not have fitted.
      if (count < left.size()) CHECK(bytes.size() + 24 > kBefore + room);
      left = left.subspan(count);
      DecodedPacket packet;
      REQUIRE(decode(std::span(bytes).subspan(kBefore), packet).ok());
      for (const AnchorUpdate& anchor : packet.anchors) told.push_back(anchor.spring);
    }
    REQUIRE(others.size() == 1);
    CHECK(others[0].spring == springs[7].spring);
    REQUIRE(told.size() == 29);
    for (std::size_t i = 0; i < told.size(); ++i) {
      CHECK(told[i] == springs[i < 7 ? i : i + 1].spring);
    }
  }
  std::vector<SpringUpdate> others;
  Bytes bytes(kBefore);
  CHECK(encode_anchors(springs, kBefore + kOne - 1, others, bytes) == 0);
  CHECK(bytes.size() == kBefore);
}

TEST_CASE("compact: names fill the remaining room", "[consensus]") {
  const std::vector<SharedId> ids(40, SharedId{1, 2});
  for (std::size_t room = 0; room < 600; ++room) {
    const std::size_t count = indices_in(room);
    Bytes bytes;
    encode_indices(1, 0, std::span(ids).first(count + 1), bytes);
    REQUIRE(bytes.size() > room);
    if (count == 0) continue;
    bytes.clear();
    encode_indices(1, 0, std::span(ids).first(count), bytes);
    REQUIRE(bytes.size() <= room);
  }
}

}  // namespace compact_test
