// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <array>
#include <limits>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/forged.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/tether.h"

namespace forged_snapshot_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

// As world_snapshot.cpp lays it out.
constexpr std::size_t kHead = 4 + 4 + 4 + 8 + 1;
constexpr std::size_t kFirstSlot = kHead + 3 * 8 + 8 + 4;
constexpr std::size_t kProps = 1 + 5 * 8 + 6 + 2 + 18 * 8;
constexpr std::size_t kName = kProps + 6;                  ///< within a slot: flag and stable id
constexpr std::size_t kLevel = kName + 1 + 8 + 5 * 8 + 1;  // origin, thresholds of rest
constexpr std::size_t kPose = kLevel + 1 + 4 + 8 + 6 * 8;
constexpr std::size_t kSlot = kPose + 13 * 8;

/// Bodies with names, a joint, a rod, a tether, contacts, and a free slot of each kind.
struct Scene {
  World world;
  ToyContacts contacts;
  Solver solver;
  std::uint32_t slots = 0;

  Scene() {
    world.set_contact_source(&contacts);
    auto& joints = world.add_block<JointBlock>();
    auto& rods = world.add_block<DistanceJoints>();
    auto& tethers = world.add_block<Tethers>();
    const Vec3 half = Vec3::Constant(0.25);
    std::array<BodyId, 4> ids;
    for (std::uint32_t i = 0; i < ids.size(); ++i) {
      BodyDef def = box_def(1.0, half, Vec3(0.6 * i, 0.0, 0.3));
      def.stable_id = 7 + i;
      ids[i] = world.add_body(def);
    }
    const BodyId ground = add_ground(world);
    const BodyId gone = world.add_body({});
    for (const BodyId id : ids) contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, id, half, {});
    joints.add(world, hinge_joint_at(world, ids[0], ids[1], Vec3(0.3, 0.0, 0.3), Vec3::UnitY()));
    joints.add(world, ball_joint_at(world, gone, ids[1], Vec3::Zero()));
    rods.add(world, {.a = ids[2], .b = ids[3], .rest_length = 0.6});
    rods.add(world, {.a = gone, .b = ids[3], .rest_length = 0.6});
    tethers.add(world, {.body = ids[3], .anchor_w = Vec3(1.8, 0.0, 0.5)});
    world.remove_body(gone);
    slots = world.slot_count();
    for (int i = 0; i < 30; ++i) solver.step(world, kFrame);
  }
};

std::vector<std::byte> of_number(double value) {
  std::vector<std::byte> bytes;
  ByteWriter(bytes).f64(value);
  return bytes;
}

}  // namespace

TEST_CASE("forged snapshot: impossible bodies are refused", "[pbd][fault]") {
  Scene scene;
  const auto bytes = scene.world.snapshot();
  bool refused = false;
  REQUIRE(survives(scene.world, forged(bytes, 0, {}), refused));
  REQUIRE_FALSE(refused);  // nothing was changed
  const std::array<std::byte, 1> level{std::byte{200}};
  const std::array<std::byte, 9> name{std::byte{1}, std::byte{8}};
  const std::array<std::byte, 4> ground{std::byte{4}};
  const auto nan = of_number(std::numeric_limits<double>::quiet_NaN());
  struct Forgery {
    const char* what;
    std::size_t at;
    std::span<const std::byte> with;
  };
  const Forgery forgeries[] = {
      {"level", kFirstSlot + kLevel, level},
      {"a name twice", kFirstSlot + kName, name},
      {"no number for a position", kFirstSlot + kPose, nan},
      {"no number for a mass", kFirstSlot + 6 + 1, nan},
      {"a free slot that is none", kFirstSlot + scene.slots * kSlot + 4, ground},
      {"a free slot that does not exist", kFirstSlot + scene.slots * kSlot + 5, level},
  };
  for (const Forgery& forgery : forgeries) {
    INFO(forgery.what);
    CHECK(survives(scene.world, forged(bytes, forgery.at, forgery.with), refused));
    CHECK(refused);
  }
}

TEST_CASE("forged snapshot: no byte anywhere breaks the world", "[pbd][fault]") {
  Scene scene;
  const auto bytes = scene.world.snapshot();
  int refusals = 0;
  for (std::size_t at = kHead; at + kCheckBytes < bytes.size(); ++at) {
    const std::array<std::byte, 1> other{bytes[at] ^ std::byte(at % 2 == 0 ? 0xff : 0x40)};
    INFO("byte " << at << " of " << bytes.size());
    bool refused = false;
    REQUIRE(survives(scene.world, forged(bytes, at, other), refused));
    refusals += refused ? 1 : 0;
    if (!refused) scene.world.restore(bytes);
  }
  CHECK(refusals > 500);
}

}  // namespace forged_snapshot_test
