// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What happens in an island depends on nothing outside of it, however many there are: large worlds
// are solved in groups of whole islands.
#include <array>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/typed_block.h"

namespace tandem::collision::island_bits_test {

using namespace tandem::pbd;
using tandem::testing::kFrame;

/// Cells far from each other. In each: two cubes that fall on each other, a ball that bounces on a
/// platform that moves, two balls on a spring, and a rod on a hinge.
class Cells {
 public:
  explicit Cells(const std::vector<int>& cells, int threads = 1)
      : solver({.contact = {.extra_rows = kNoLimit}, .threads = threads}) {
    world.set_contact_source(&shapes);
    shapes.add(world, {.body = world.add_body({.type = BodyType::Static}), .shape = HalfSpace{}});
    for (const int cell : cells) add(cell);
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) solver.step(world, kFrame);
  }
  std::span<const BodyId> bodies(std::size_t cell) const { return cells_[cell]; }

  World world;
  Solver solver;

 private:
  static constexpr int kPerCell = 7;
  static constexpr int kNoLimit = 1'000'000'000;  // a budget is shared with all others

  BodyId body(const Vec3& at, const Shape& shape, double restitution = 0.0,
              BodyType type = BodyType::Dynamic) {
    const MassProperties mass = mass_properties(shape, 300.0);
    const BodyId id = world.add_body(
        {.type = type, .pose = {.position = at}, .mass = mass.mass, .inertia = mass.inertia});
    shapes.add(world, {.body = id, .shape = shape, .material = {.restitution = restitution}});
    return id;
  }
  void add(int cell) {
    const Vec3 at(4.0 * (cell % 20), 4.0 * (cell / 20), 0.0);
    const Box cube{0.1, 0.1, 0.1};
    const Sphere ball{0.1};
    std::array<BodyId, kPerCell> made{};
    made[0] = body(at + Vec3(0.0, 0.0, 0.1), cube);
    made[1] = body(at + Vec3(0.03, 0.02, 0.35 + 0.001 * cell), cube);
    made[2] = body(at + Vec3(1.0, 0.0, 0.1), cube, 0.5, BodyType::Kinematic);
    world.set_twist(made[2], {.linear = Vec3(0.0, 0.01, 0.05)});
    made[3] = body(at + Vec3(1.0, 0.0, 0.6), ball, 0.7);
    made[4] = body(at + Vec3(2.0, 0.0, 0.2), ball);
    made[5] = body(at + Vec3(2.0, 0.3, 0.5), ball);
    springs.add(world, {.a = made[4], .b = made[5], .rest_length = 0.3, .compliance = 1e-3});
    made[6] = body(at + Vec3(3.0, 0.3, 1.0), cube);
    joints.add(world, hinge_joint_at(world, {}, made[6], at + Vec3(3.0, 0.0, 1.0), Vec3::UnitX()));
    cells_.push_back(made);
  }

  CollisionScene shapes;
  TypedBlock<DistanceJoint>& springs = world.add_block<TypedBlock<DistanceJoint>>();
  JointBlock& joints = world.add_block<JointBlock>();
  std::vector<std::array<BodyId, kPerCell>> cells_;
};

TEST_CASE("islands: the same bits alone and among a thousand bodies", "[collision][determinism]") {
  std::vector<int> all;
  for (int cell = 0; cell < 200; ++cell) all.push_back(cell);
  const int threads = GENERATE(1, 2);
  CAPTURE(threads);
  Cells together(all, threads);
  together.steps(90);
  CHECK(together.solver.options().threads == threads);
  for (const int cell : {0, 57, 130, 199}) {
    Cells alone({cell});
    alone.steps(90);
    CAPTURE(cell);
    for (std::size_t i = 0; i < alone.bodies(0).size(); ++i) {
      CAPTURE(i);
      const BodyState one = alone.world.state(alone.bodies(0)[i]);
      const BodyState other =
          together.world.state(together.bodies(static_cast<std::size_t>(cell))[i]);
      CHECK(one.pose.position == other.pose.position);
      CHECK(one.pose.orientation.coeffs() == other.pose.orientation.coeffs());
      CHECK(one.twist.linear == other.twist.linear);
      CHECK(one.twist.angular == other.twist.angular);
    }
  }
}

}  // namespace tandem::collision::island_bits_test
