// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The solver's threads: who does what changes no bit, and under the thread sanitizer no two of them
// touch the same thing. Data that they share here is plain on purpose.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/workers.h"

namespace threads_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf = Vec3::Constant(0.1);  ///< m

/// Columns of two boxes in a field, wider than what the solver gives to one worker: 256 bodies, 64
/// rows, and levels of 128 rows. Every other column lies there and falls asleep, the others are
/// dropped sliding.
struct Columns {
  static constexpr int kCount = 360;
  World world;
  ToyContacts contacts;
  FixedTargets agreed;
  std::vector<BodyId> lower;
  std::vector<BodyId> upper;
  Solver solver;

  explicit Columns(int threads)
      : solver({.substeps = 2, .refine = false, .sleep_after = 0.05, .threads = threads}) {
    const BodyId ground = add_ground(world);
    auto& joints = world.add_block<JointBlock>();
    for (int i = 0; i < kCount; ++i) {
      const bool lies = i % 2 == 0;
      const Vec3 foot(1.0 * (i % 20), 1.0 * (i / 20), lies ? 0.1 : 0.1 + 0.0005 * i);
      BodyDef def = box_def(1.0, kHalf, foot);
      if (!lies) def.twist = {Vec3(0.2, 0.001 * i, 0.0), Vec3(0.0, 0.0, 0.5)};
      lower.push_back(world.add_body(def));
      def.pose.position.z() += 0.2;
      upper.push_back(world.add_body(def));
      contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, lower.back(), kHalf, {});
      contacts.box_on_box(lower.back(), kHalf, upper.back(), kHalf, {});
    }
    for (const std::size_t i : {1u, 3u}) {
      joints.add(world, ball_joint_at(world, upper[i], upper[i + 2],
                                      world.pose(upper[i]).position + Vec3(1.0, 0.0, 0.0)));
      agreed.targets.push_back({.body = lower[i + 4],
                                .pose = {world.pose(lower[i + 4]).position, Quat::Identity()},
                                .share = 0.05});
    }
    world.set_contact_source(&contacts);
    world.set_target_source(&agreed);
  }

  /// The columns that sleep are hit, one in five.
  void kick() {
    for (std::size_t i = 0; i < upper.size(); i += 10) {
      world.apply_impulse(upper[i], Vec3(0.5, 0.0, 0.0), world.pose(upper[i]).position);
    }
  }
  int asleep() const {
    int count = 0;
    for (std::uint32_t i = 0; i < world.slot_count(); ++i) count += world.awake_at(i) ? 0 : 1;
    return count;
  }
};

}  // namespace

TEST_CASE("threads: every index is given out once", "[pbd][unit]") {
  for (const int count : {1, 2, 3}) {
    Workers workers(count);
    CHECK(workers.count() == count);
    for (const std::size_t size : {0u, 1u, 7u, 8u, 1000u}) {
      std::vector<int> taken(size, 0);
      std::vector<int> fits(size, 0);
      workers.for_chunks(size, 7, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
          ++taken[i];
          fits[i] = count == 1 || end - begin <= 7 ? 1 : 0;
        }
      });
      CAPTURE(count, size);
      CHECK(taken == std::vector<int>(size, 1));
      CHECK(fits == std::vector<int>(size, 1));
    }
  }
  CHECK(names(refusal([] { Workers none(0); }), "Workers: count", "0", "1 to 64"));
  CHECK(names(refusal([] { Workers many(65); }), "Workers: count", "65", "1 to 64"));
}

TEST_CASE("threads: what a stage did is seen in the next one, forwards and backwards",
          "[pbd][unit]") {
  constexpr std::uint32_t kCells = 96;
  constexpr std::uint32_t kStages = 50;
  // Each stage every cell takes over its right neighbour's number, which another chunk wrote: a
  // ring that turns by one cell a stage. Stages have 96 chunks, 48, 32, or one.
  std::vector<std::uint32_t> starts{0};
  std::vector<std::uint32_t> stage_of;
  for (std::uint32_t stage = 0; stage < kStages; ++stage) {
    const std::uint32_t chunks = stage % 4 == 3 ? 1 : kCells / (stage % 4 + 1);
    starts.push_back(starts.back() + chunks);
    stage_of.resize(starts.back(), stage);
  }
  for (const int count : {1, 2, 3, 8}) {
    for (const bool reverse : {false, true}) {
      CAPTURE(count, reverse);
      Workers workers(count);
      std::array<std::vector<std::uint32_t>, 2> ring;
      for (std::uint32_t i = 0; i < kCells; ++i) ring[0].push_back(i);
      ring[1].resize(kCells);
      workers.run(starts, reverse, [&](std::uint32_t chunk, int) {
        const std::uint32_t stage = stage_of[chunk];
        const std::uint32_t nth = reverse ? kStages - 1 - stage : stage;
        const std::uint32_t cells = kCells / (starts[stage + 1] - starts[stage]);
        const std::uint32_t begin = cells * (chunk - starts[stage]);
        for (std::uint32_t i = begin; i < begin + cells; ++i) {
          ring[(nth + 1) % 2][i] = ring[nth % 2][(i + 1) % kCells];
        }
      });
      for (std::uint32_t i = 0; i < kCells; ++i) CHECK(ring[0][i] == (i + kStages) % kCells);
    }
  }
}

TEST_CASE("threads: nobody waits for a worker that does not come", "[pbd][unit]") {
  // The calling thread does whatever nobody else takes: more workers than there can be cores.
  Workers workers(64);
  std::vector<int> by(1000, -1);
  for (int round = 0; round < 20; ++round) {
    workers.for_chunks(by.size(), 1,
                       [&](std::size_t begin, std::size_t, int worker) { by[begin] = worker; });
    CHECK(std::count(by.begin(), by.end(), -1) == 0);
    by.assign(by.size(), -1);
  }
}

TEST_CASE("threads: a field of columns has the same bits on one, two, three and eight threads",
          "[pbd][sleep][unit]") {
  constexpr int kSteps = 12;
  constexpr int kKick = 8;
  std::vector<std::vector<std::byte>> expected;
  for (const int threads : {1, 2, 3, 8}) {
    Columns scene(threads);
    int most_asleep = 0;
    for (int i = 0; i < kSteps; ++i) {
      const int before = scene.asleep();
      if (i == kKick) scene.kick();
      const StepReport& report = scene.solver.step(scene.world, kFrame);
      REQUIRE(report.status == StepStatus::Ok);
      if (i == 0) {
        // More than all groups can have without one being shared out.
        CHECK(report.awake == 2 * Columns::kCount);
        CHECK(report.awake > 256 * report.groups);
        CHECK(scene.world.contacts()->contacts().size() >= Columns::kCount);
      }
      if (i == kKick) CHECK(scene.asleep() < before);
      most_asleep = std::max(most_asleep, scene.asleep());
      // All that the next step depends on, forces included.
      const auto bytes = scene.world.snapshot();
      if (threads == 1) {
        expected.push_back(bytes);
      } else if (bytes != expected[static_cast<std::size_t>(i)]) {
        FAIL(threads << " threads part from one in step " << i);
      }
    }
    CHECK(most_asleep >= Columns::kCount / 2);
    CHECK(most_asleep < 2 * Columns::kCount);
  }
}

}  // namespace threads_test
