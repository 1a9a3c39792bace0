// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/material.h"

#include "fixture.h"
#include "tandem/pbd/solver.h"

namespace material_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;
namespace pbd = tandem::pbd;

TEST_CASE("material: the later of two rules counts, either way round", "[collision][unit]") {
  const auto friction = [](Combine a, Combine b) {
    const Material one{.friction = 0.2, .friction_rule = a};
    const Material two{.friction = 0.8, .friction_rule = b};
    CHECK(combined_friction(one, two) == combined_friction(two, one));
    return combined_friction(one, two);
  };
  CHECK(friction(Combine::Default, Combine::Default) == Approx(0.4));
  CHECK(friction(Combine::GeometricMean, Combine::Default) == Approx(0.4));
  CHECK(friction(Combine::Average, Combine::GeometricMean) == Approx(0.5));
  CHECK(friction(Combine::Average, Combine::Minimum) == 0.2);
  CHECK(friction(Combine::Multiply, Combine::Minimum) == Approx(0.16));
  CHECK(friction(Combine::Multiply, Combine::Maximum) == 0.8);

  const auto restitution = [](Combine a, Combine b) {
    return combined_restitution({.restitution = 0.1, .restitution_rule = a},
                                {.restitution = 0.9, .restitution_rule = b});
  };
  CHECK(restitution(Combine::Default, Combine::Default) == 0.9);
  CHECK(restitution(Combine::Default, Combine::GeometricMean) == Approx(0.3));
  CHECK(restitution(Combine::Minimum, Combine::Default) == 0.1);
}

TEST_CASE("material: equal groups decide before category and mask", "[collision][unit]") {
  const Filter plain;
  CHECK(may_meet(plain, plain));
  CHECK_FALSE(may_meet({.category = 2}, {.mask = 1}));
  CHECK(may_meet({.category = 2, .group = 3}, {.mask = 1, .group = 3}));
  CHECK_FALSE(may_meet({.group = -3}, {.group = -3}));
  CHECK(may_meet({.group = -3}, {.group = -4}));
  CHECK_FALSE(may_meet({.category = 2, .group = 3}, {.mask = 1, .group = 4}));
}

TEST_CASE("material: values out of range are refused by name", "[collision][fault]") {
  Fixture f;
  const ColliderId id = f.scene.add(f.world, {.body = f.body({}), .shape = Sphere{0.5}});
  CHECK_THROWS_WITH(f.scene.set_material(id, {.friction = NAN}),
                    Contains("friction must be") && Contains("is nan"));
  CHECK_THROWS_WITH(f.scene.set_material(id, {.restitution = -1}),
                    Contains("restitution must be") && Contains("is -1"));
  CHECK_THROWS_WITH(f.scene.set_material(id, {.friction_rule = static_cast<Combine>(9)}),
                    Contains("friction_rule must be") && Contains("is 9"));
  CHECK_THROWS_WITH(f.scene.set_filter({5, 0}, {}), Contains("collider 5"));
  CHECK(f.scene.collider(id).material.friction == 0.5);
}

TEST_CASE("material: a change counts from the next step on", "[collision][unit]") {
  Fixture f;
  const BodyId ground = f.body({}, BodyType::Static);
  const ColliderId floor = f.scene.add(f.world, {.body = ground, .shape = HalfSpace{}});
  const BodyId ball = f.body(at(0, 0, 0.5));
  const ColliderId round = f.scene.add(f.world, {.body = ball, .shape = Sphere{0.5}});
  f.add(Sphere{0.5}, at(0.9, 0, 0.5));
  REQUIRE(f.collect().size() == 3);

  f.scene.set_material(round, {.friction = 0.8, .friction_rule = Combine::Maximum});
  REQUIRE(f.collect().size() == 3);
  for (const Manifold& m : f.manifolds) {
    CHECK(m.friction == (m.body_a == ball.index || m.body_b == ball.index ? 0.8 : 0.5));
  }

  f.scene.set_filter(round, {.mask = 0});
  CHECK(f.collect().size() == 1);
  f.scene.set_filter(round, {});
  CHECK(f.collect().size() == 3);
  f.scene.set_filter(floor, {.mask = 0});
  CHECK(f.collect().size() == 1);
  f.scene.set_filter(floor, {.group = 1});
  CHECK(f.collect().size() == 3);
}

TEST_CASE("material: changes are part of a snapshot", "[collision][snapshot]") {
  Fixture f;
  f.fixed(HalfSpace{});
  const BodyId ball = f.body(at(0, 0, 0.5));
  const ColliderId round = f.scene.add(f.world, {.body = ball, .shape = Sphere{0.5}});
  f.world.set_contact_source(&f.scene);
  pbd::Solver solver;
  REQUIRE(solver.step(f.world, kDt).status == pbd::StepStatus::Ok);
  const auto bytes = f.world.snapshot();
  f.scene.set_filter(round, {.mask = 0});
  f.scene.set_material(round, {.friction = 0.1});
  for (int i = 0; i < 60; ++i) CHECK(solver.step(f.world, kDt).status == pbd::StepStatus::Ok);
  CHECK(f.world.pose(ball).position.z() < -3.0);  // through the floor
  f.world.restore(bytes);
  CHECK(f.scene.collider(round).filter.mask == ~0u);
  CHECK(f.scene.collider(round).material.friction == 0.5);
  for (int i = 0; i < 60; ++i) CHECK(solver.step(f.world, kDt).status == pbd::StepStatus::Ok);
  CHECK(f.world.pose(ball).position.z() == Approx(0.5).margin(1e-4));
}

TEST_CASE("material: a sensor makes no contacts", "[collision][unit]") {
  Fixture f;
  f.fixed(HalfSpace{});
  f.add(Sphere{0.5}, at(0, 0, 0.45));
  f.scene.add(f.world, {.body = f.body(at(0, 0, 0.5), BodyType::Static),
                        .shape = Box{Vec3::Constant(1.0)},
                        .sensor = true});
  CHECK(f.collect().size() == 1);
}

}  // namespace material_test
