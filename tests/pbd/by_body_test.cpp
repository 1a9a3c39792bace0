// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/by_body.h"

#include <algorithm>
#include <map>
#include <utility>

#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/cloth_block.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/random.h"
#include "tandem/pbd/tether.h"

namespace by_body_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// A row of boxes on the ground, each held to the next one in turn by each kind of row, at once
/// after a step.
struct Crowd {
  static constexpr std::uint32_t kCount = 40;
  World world;
  ToyContacts contacts;
  Solver solver;
  BodyId ground;
  std::vector<BodyId> boxes;
  JointBlock* joints = nullptr;
  DistanceJoints* rods = nullptr;

  Crowd() {
    world.set_contact_source(&contacts);
    joints = &world.add_block<JointBlock>();
    rods = &world.add_block<DistanceJoints>();
    auto& cloth = world.add_block<ClothBlock>();
    ground = add_ground(world);
    const Vec3 half(0.5, 0.5, 0.5);
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const double x = 1.2 * i;
      boxes.push_back(world.add_body(box_def(1.0, half, Vec3(x, 0.0, 0.5))));
      contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, boxes.back(), half, {});
      if (i == 0) continue;
      const BodyId before = boxes[i - 1];
      if (i % 3 == 0) {
        joints->add(world, ball_joint_at(world, before, boxes[i], Vec3(x - 0.6, 0.0, 0.5)));
      } else if (i % 3 == 1) {
        rods->add(world, {.a = before, .b = boxes[i], .rest_length = 1.2});
      } else {
        cloth.add(world, ClothTetherDef{.a = before, .b = boxes[i], .length = 2.0});
      }
    }
    solver.step(world, kFrame);
  }
};

}  // namespace

TEST_CASE("by body: the rows of a body are those that name it", "[pbd][unit]") {
  ByBody rows;
  std::map<std::uint32_t, std::pair<std::uint32_t, std::uint32_t>> known;
  SplitMix64 random(7);
  for (int k = 0; k < 2000; ++k) {
    const auto row = static_cast<std::uint32_t>(random.below(30));
    if (known.erase(row) != 0) {
      rows.remove(row);
    } else {
      const auto a = static_cast<std::uint32_t>(random.below(6));
      const auto b =
          random.below(3) == 0 ? BodyId::kNone : static_cast<std::uint32_t>(random.below(6));
      known[row] = {a, b};
      rows.add(row, a, b);
    }
    if (k % 500 == 499) {  // what was known of them is gone
      rows.outdate();
      rows.renew([&] {
        for (const auto& [each, named] : known) rows.add(each, named.first, named.second);
      });
    }
    for (std::uint32_t body = 0; body < 7; ++body) {
      std::vector<std::uint32_t> expected;
      for (const auto& [each, named] : known) {
        if (named.first == body || named.second == body) expected.push_back(each);
      }
      REQUIRE(rows.rows_of(body) == expected);
    }
  }
}

TEST_CASE("by body: bodies removed together take only their own contacts and rows along",
          "[pbd][unit]") {
  Crowd crowd;
  const auto all = crowd.world.contacts()->contacts();
  REQUIRE(all.size() == Crowd::kCount);
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < Crowd::kCount; ++i) {
    if (i % 4 != 1) left.push_back(crowd.boxes[i].index);
  }
  for (std::uint32_t i = 1; i < Crowd::kCount; i += 4) crowd.world.remove_body(crowd.boxes[i]);
  std::vector<std::uint32_t> touching;
  for (const Contact& contact : crowd.world.contacts()->contacts()) {
    touching.push_back(contact.manifold.body_a == crowd.ground.index ? contact.manifold.body_b
                                                                     : contact.manifold.body_a);
  }
  std::sort(touching.begin(), touching.end());
  CHECK(touching == left);
  std::vector<ConstraintEdge> edges;
  for (const auto& block : crowd.world.blocks()) block->append_edges(edges);
  // Of 39 rows, those from i - 1 to i for which neither is 1 modulo 4.
  CHECK(edges.size() == left.size() + 19);
  for (const ConstraintEdge& edge : edges) {
    CHECK(crowd.world.body_at(edge.body_a).valid());
    CHECK(crowd.world.body_at(edge.body_b).valid());
  }
}

TEST_CASE("by body: a body is joined to those that some edge names with it", "[pbd][unit]") {
  Crowd crowd;
  for (std::uint32_t i = 2; i < Crowd::kCount; i += 7) crowd.world.remove_body(crowd.boxes[i]);
  for (const auto& block : crowd.world.blocks()) {
    std::vector<ConstraintEdge> edges;
    block->append_edges(edges);
    for (std::uint32_t body = 0; body < crowd.world.slot_count(); ++body) {
      std::vector<std::uint32_t> expected;
      for (const ConstraintEdge& edge : edges) {
        if (edge.body_a == body) expected.push_back(edge.body_b);
        if (edge.body_b == body) expected.push_back(edge.body_a);
      }
      std::vector<std::uint32_t> joined;
      block->append_joined(body, joined);
      std::sort(expected.begin(), expected.end());
      std::sort(joined.begin(), joined.end());
      CHECK(joined == expected);
    }
  }
}

// Rows that came in another order leave their slots in the same one.
TEST_CASE("by body: a restored world is the same one after bodies have gone", "[pbd][snapshot]") {
  Crowd crowd;
  for (std::uint32_t i = 0; i < Crowd::kCount; i += 3) {  // slots that are used again
    if (i + 1 >= Crowd::kCount) continue;
    const auto ids = joint_ids(*crowd.joints);
    crowd.joints->remove(ids[(5 * i) % ids.size()]);
    crowd.joints->add(crowd.world, ball_joint_at(crowd.world, crowd.boxes[i], crowd.boxes[i + 1],
                                                 Vec3(1.2 * i + 0.6, 0.0, 0.5)));
    crowd.rods->add(crowd.world, {.a = crowd.boxes[39], .b = crowd.boxes[i + 1]});
  }
  crowd.world.remove_body(crowd.boxes[7]);
  const std::vector<std::byte> saved = crowd.world.snapshot();
  const auto remove_more = [&] {
    for (const std::uint32_t i : {4u, 5u, 12u, 20u}) crowd.world.remove_body(crowd.boxes[i]);
    const std::uint32_t slot = crowd.joints
                                   ->add(crowd.world, ball_joint_at(crowd.world, crowd.boxes[30],
                                                                    crowd.boxes[33], Vec3::Zero()))
                                   .index;
    return std::pair(slot, crowd.world.snapshot());
  };
  const auto first = remove_more();
  crowd.world.restore(saved);
  const auto second = remove_more();
  CHECK(first.first == second.first);
  CHECK(first.second == second.second);
}

TEST_CASE("by body: each kinematic body has one target, the last", "[pbd][unit]") {
  KinematicTargets targets;
  std::map<std::uint32_t, double> known;
  SplitMix64 random(3);
  for (int k = 0; k < 3000; ++k) {
    const auto slot = static_cast<std::uint32_t>(random.below(20));
    if (random.below(3) == 0) {
      targets.remove(slot);
      known.erase(slot);
    } else {
      targets.set({slot, {Vec3(k, 0.0, 0.0), Quat::Identity()}});
      known[slot] = k;
    }
    REQUIRE(targets.all().size() == known.size());
    for (std::uint32_t i = 0; i < 20; ++i) {
      const auto pose = targets.pose_of(i);
      REQUIRE(pose.has_value() == known.contains(i));
      if (pose) REQUIRE(pose->position.x() == known[i]);
    }
    if (k % 100 == 99) {  // as each step does
      targets.clear();
      known.clear();
    }
  }
}

}  // namespace by_body_test
