// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A slot is no name: what takes the place of something that is gone inherits nothing from it.
#include <limits>

#include "support/catch.h"
#include "tandem/pbd/world_copy.h"
#include "tandem/scene.h"

namespace slot_test {

using namespace tandem;
using collision::ColliderDef;
using collision::ColliderId;
using pbd::Manifold;
using pbd::StepStatus;

namespace {

constexpr double kStep = 1.0 / 60.0;

void run(Scene& scene, double seconds) {
  for (int i = 0; i < static_cast<int>(seconds / kStep); ++i) scene.step(kStep);
}

ColliderId collider_of(const Scene& scene, BodyId body) {
  for (std::uint32_t i = 0; i < scene.shapes().slot_count(); ++i) {
    const ColliderId id = scene.shapes().collider_at(i);
    if (id.valid() && scene.shapes().collider(id).body == body) return id;
  }
  return {};
}

/// Says what the test wants, among what is true.
class Liar final : public pbd::ContactSource {
 public:
  std::vector<Manifold> lies;

  void collect(const pbd::World&, double, pbd::Workers&, std::vector<Manifold>& out) override {
    out.insert(out.end(), lies.begin(), lies.end());
  }
  void limit_motion(const pbd::World&, std::span<const Pose>, pbd::Workers&,
                    std::vector<pbd::MotionLimit>& limits) override {
    limits.assign(1, {.body = 1000});
  }
  void remove_body(BodyId) override {}
  void save(pbd::ByteWriter&) const override {}
  void load(pbd::ByteReader&) override {}
};

}  // namespace

TEST_CASE("slot: a larger collider in the place of a sleeper's is felt", "[scene][change]") {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId box = scene.add(Box{0.2, 0.2, 0.2}, {.pose = {.position = {0.0, 0.0, 0.2}}});
  const BodyId on_top = scene.add(Box{0.2, 0.2, 0.2}, {.pose = {.position = {0.0, 0.0, 0.6}}});
  run(scene, 2.0);
  REQUIRE_FALSE(scene.world().awake(box));
  scene.shapes().remove(collider_of(scene, box));
  scene.shapes().add(scene.world(), {.body = box, .shape = Box{0.4, 0.4, 0.4}});
  run(scene, 3.0);
  CHECK(scene.pose(box).position.z() == Approx(0.4).margin(2e-3));
  CHECK(scene.pose(on_top).position.z() == Approx(1.0).margin(4e-3));
}

TEST_CASE("slot: a collider that goes to another body takes no contact along", "[scene][change]") {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId lower = scene.add(Box{0.2, 0.2, 0.2}, {.pose = {.position = {0.0, 0.0, 0.2}}});
  const BodyId upper = scene.add(Box{0.2, 0.2, 0.2}, {.pose = {.position = {0.0, 0.0, 0.6}}});
  const BodyId other = scene.world().add_body({.pose = {.position = {3.0, 0.0, 0.2}}, .mass = 1.0});
  run(scene, 1.5);
  REQUIRE_FALSE(scene.world().awake(upper));
  scene.shapes().remove(collider_of(scene, lower));
  scene.shapes().add(scene.world(), {.body = other, .shape = Box{0.2, 0.2, 0.2}});
  run(scene, 0.2);
  CHECK(scene.pose(upper).position.z() < 0.5);  // nothing holds it
  CHECK(scene.world().state(other).twist.linear.norm() < 0.1);
}

TEST_CASE("slot: a collider does not follow the body that takes its body's slot",
          "[scene][change]") {
  Scene scene;
  pbd::World& world = scene.world();
  const BodyId gone = scene.add(Sphere{0.5});
  const BodyId ball = scene.add(Sphere{0.1}, {.pose = {.position = {5.0, 0.0, 0.0}}});
  world.set_contact_source(nullptr);
  world.remove_body(gone);
  const BodyId next = world.add_body({.pose = {.position = {5.0, 0.0, 0.3}}, .mass = 1.0});
  REQUIRE(next.index == gone.index);
  world.set_contact_source(&scene.shapes());
  run(scene, 0.1);
  CHECK(world.state(ball).twist.linear.z() == Approx(world.state(next).twist.linear.z()));
  CHECK(world.contacts()->contacts().empty());
}

TEST_CASE("slot: manifolds of removed bodies, with NaN, or of no shape are left out",
          "[scene][fault]") {
  pbd::World world;
  Liar liar;
  world.set_contact_source(&liar);
  const BodyId a = world.add_body({.mass = 1.0});
  const BodyId b = world.add_body({.pose = {.position = {0.0, 0.0, 1.0}}, .mass = 1.0});
  const BodyId gone = world.add_body({.mass = 1.0});
  world.remove_body(gone);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Manifold good{.key = 1, .body_a = a.index, .body_b = b.index, .count = 1};
  liar.lies.assign(9, good);
  for (std::size_t i = 0; i < liar.lies.size(); ++i) liar.lies[i].key = i;
  liar.lies[0].body_b = gone.index;
  liar.lies[1].body_b = 77;
  liar.lies[2].count = 5;
  liar.lies[3].count = -1;
  liar.lies[4].normal.x() = nan;
  liar.lies[5].points[0].anchor_a_l.y() = nan;
  liar.lies[6].normal.setZero();
  liar.lies[7].friction = -1.0;
  liar.lies[8].body_b = a.index;
  pbd::Solver solver;
  for (int i = 0; i < 5; ++i) CHECK(solver.step(world, kStep).status == StepStatus::Ok);
  CHECK(world.contacts()->contacts().empty());
  CHECK(world.state(a).pose.position.allFinite());
}

TEST_CASE("slot: an earlier displacement does not count for a body added later",
          "[scene][change]") {
  pbd::World world;
  world.add_block<pbd::JointBlock>();
  const BodyId body = world.add_body({.mass = 1.0});
  pbd::WorldCopy copy;
  copy.assign(world);
  copy.displace(body.index, copy.world().state(body));
  auto* joints = dynamic_cast<pbd::JointBlock*>(copy.world().blocks()[0].get());
  REQUIRE(joints != nullptr);
  // More of them than a vector has in reserve.
  for (int i = 0; i < 40; ++i) {
    const BodyId late = copy.world().add_body({.pose = {.position = {1.0 + i, 0, 0}}, .mass = 1.0});
    joints->add(copy.world(), pbd::ball_joint_at(copy.world(), {}, late, Vec3(1.0 + i, 0.0, 0.5)));
  }
  pbd::Solver solver;
  CHECK(solver.step(copy.world(), kStep).status == StepStatus::Ok);
}

TEST_CASE("slot: a body made static is seen at rest by every solver", "[scene][change]") {
  // Its last velocity stayed in the solver's scratch memory.
  struct Pull final : pbd::TargetSource {
    BodyId body;
    void collect(const pbd::World&, double, const pbd::SolverOptions&,
                 std::vector<pbd::PoseTarget>& out) override {
      out.push_back({.body = body, .pose = {.position = {0.0, 0.0, 0.3}}, .share = 0.5});
    }
  } pull;
  Scene scene;
  const BodyId floor = scene.add(Box{1.0, 1.0, 0.1}, {.twist = {.linear = {0.0, 0.0, 5.0}}});
  const BodyId box = scene.add(Box{0.1, 0.1, 0.1}, {.pose = {.position = {0.0, 0.0, 0.6}}});
  pull.body = box;
  scene.world().set_target_source(&pull);
  scene.step(kStep);
  scene.world().set_type(floor, BodyType::Static);
  pbd::WorldCopy copy;
  copy.assign(scene.world());
  copy.world().set_target_source(&pull);
  pbd::Solver fresh;
  for (int i = 0; i < 30; ++i) {
    scene.step(kStep);
    fresh.step(copy.world(), kStep);
  }
  CHECK(scene.world().state(box).pose.position == copy.world().state(box).pose.position);
}

}  // namespace slot_test
