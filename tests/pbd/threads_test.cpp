// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The solver's threads: who does what changes no bit, and under the thread sanitizer no two of them
// touch the same thing. Data that they share here is plain on purpose.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/tether.h"
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

/// Chains of four boxes on ball joints that fall on the ground, hang on springs from one post, are
/// tied to places, lie on a floor that moves, or bounce: groups of all kinds, whose rows share a
/// body that cannot move.
struct Chains {
  static constexpr int kCount = 60;
  World world;
  ToyContacts contacts;
  Solver solver;

  explicit Chains(int threads)
      : solver({.substeps = 3, .sleep_after = 0.0, .threads = threads, .measure_stages = true}) {
    const BodyId ground = add_ground(world);
    const BodyId post = add_ground(world);
    BodyDef moving{.type = BodyType::Kinematic};
    moving.twist.linear = Vec3(0.5, 0.0, 0.0);
    const BodyId floor = world.add_body(moving);
    auto& joints = world.add_block<JointBlock>();
    auto& springs = world.add_block<DistanceJoints>();
    auto& tethers = world.add_block<Tethers>();
    for (int i = 0; i < kCount; ++i) {
      BodyId last;
      for (int k = 0; k < 4; ++k) {
        const Vec3 at(0.25 * k, 1.0 * i, 0.12 + 0.002 * i);
        BodyDef def = box_def(1.0, kHalf, at);
        def.twist = {Vec3(0.1 * k, 0.0, i % 5 == 4 ? -3.0 : 0.0), Vec3(0.0, 0.3, 0.0)};
        const BodyId body = world.add_body(def);
        const ToyContacts::Surface surface{.restitution = i % 5 == 4 ? 0.6 : 0.0};
        contacts.box_on_plane(i % 5 == 3 ? floor : ground, Vec3::UnitZ(), 0.0, body, kHalf,
                              surface);
        if (k > 0) {
          joints.add(world, ball_joint_at(world, last, body, at - Vec3(0.125, 0.0, 0.0)));
        } else if (i % 5 == 1) {
          springs.add(world, {.a = post, .b = body, .rest_length = 0.5, .compliance = 1e-3});
        } else if (i % 5 == 2) {
          tethers.add(world, {.body = body, .anchor_w = at + Vec3(0.0, 0.0, 0.3)});
        }
        last = body;
      }
    }
    world.set_contact_source(&contacts);
  }
};

/// Acts on all bodies of a group, none of which it names beforehand.
class Field final : public ConstraintBlock {
 public:
  std::string_view name() const override { return "field"; }
  int order() const override { return 0; }
  bool empty() const override { return false; }
  double project(const SubstepContext& ctx) override {
    bodies += static_cast<int>(ctx.members.size());
    return 0.0;
  }
  BlockReport report() const override { return {.name = name()}; }
  void save(ByteWriter&) const override {}
  void load(ByteReader&) override {}

  int bodies = 0;  ///< of all groups and substeps
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
          fits[i] = end - begin <= 7 || (begin == 0 && end == size) ? 1 : 0;
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

TEST_CASE("threads: tasks are begun in order, each once, and so is the whole", "[pbd][unit]") {
  for (const int count : {1, 2, 3, 8}) {
    CAPTURE(count);
    Workers workers(count);
    for (const std::uint32_t tasks : {0u, 1u, 2u, 50u}) {
      std::vector<int> taken(tasks, 0);
      std::atomic<std::uint32_t> begun{0};
      std::atomic<bool> in_order{true};
      workers.for_tasks(tasks, [&](std::uint32_t task, int) {
        ++taken[task];
        // Each of the others may have begun one of those before it.
        if (begun.fetch_add(1) + static_cast<std::uint32_t>(count) <= task) in_order = false;
      });
      CHECK(taken == std::vector<int>(tasks, 1));
      CHECK(in_order);
    }
    std::vector<std::atomic<int>> came(static_cast<std::size_t>(count));
    workers.for_each([&](int worker) { ++came[static_cast<std::size_t>(worker)]; });
    CHECK(came[0] == 1);
    for (const std::atomic<int>& times : came) CHECK(times <= 1);
    for (const std::size_t lucky : {0u, 399u, 1000u}) {
      const bool any = workers.any_chunk(1000, 10, [&](std::size_t begin, std::size_t end) {
        return begin <= lucky && lucky < end;
      });
      CHECK(any == (lucky < 1000));
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
        // Some are solved at once, and the bodies of the largest one are shared out.
        CHECK(report.awake == 2 * Columns::kCount);
        CHECK(report.groups > 2);
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

TEST_CASE("threads: groups with all kinds of rows have the same bits solved at once",
          "[pbd][joint][unit]") {
  std::vector<std::uint64_t> expected;
  for (const int threads : {1, 2, 3, 8}) {
    Chains scene(threads);
    for (int i = 0; i < 12; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      const StepReport& report = scene.solver.step(scene.world, kFrame);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      REQUIRE(report.status == StepStatus::Ok);
      CHECK(report.groups > 10);
      // Stages of groups that ran side by side add up to no more than the step.
      CHECK(report.stage_s[static_cast<std::size_t>(Stage::Project)] > 0.0);
      CHECK(report.total_s() <= took.count());
      if (threads == 1) {
        expected.push_back(scene.world.hash());
      } else if (scene.world.hash() != expected[static_cast<std::size_t>(i)]) {
        FAIL(threads << " threads part from one in step " << i);
      }
    }
  }
}

TEST_CASE("threads: a block that names no bodies is asked for all groups, in turn", "[pbd][unit]") {
  for (const int threads : {1, 3}) {
    World world;
    auto& field = world.add_block<Field>();
    for (int i = 0; i < 2000; ++i) world.add_body({});
    Solver solver({.substeps = 1, .sleep_after = 0.0, .threads = threads});
    CHECK(solver.step(world, kFrame).groups > 3);
    CHECK(field.bodies == 2000);
  }
}

}  // namespace threads_test
