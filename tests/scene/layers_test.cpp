// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/layers.h"

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/scene.h"

namespace layers_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

TEST_CASE("layers: layers that ignore each other do not meet, all others do", "[scene][layers]") {
  collision::Layers layers{"room", "players", "debris"};
  const collision::Filter before = layers["debris"];
  layers.ignore("debris", "debris");
  layers.ignore("players", "debris");
  for (const auto* const a : {"room", "players", "debris"}) {
    for (const auto* const b : {"room", "players", "debris"}) {
      const bool ignored = (a == std::string("debris") && b != std::string("room")) ||
                           (b == std::string("debris") && a != std::string("room"));
      CHECK(collision::may_meet(layers[a], layers[b]) != ignored);
    }
  }
  CHECK(collision::may_meet(before, before));         // asked for before it was said
  CHECK(collision::may_meet({}, layers["players"]));  // no filter: the first layer
  layers.ignore("room", "players");
  CHECK_FALSE(collision::may_meet({}, layers["players"]));
}

TEST_CASE("layers: errors name the unknown layer and the known ones", "[scene][layers]") {
  collision::Layers layers{"room", "debris"};
  CHECK(names(refusal([&] { layers["debri"]; }), "Layers: name", "\"debri\"", "room, debris"));
  CHECK(names(refusal([&] { layers.ignore("room", "x"); }), "name", "\"x\"", "room, debris"));
  CHECK(names(refusal([] { collision::Layers{"a", "a"}; }), "name", "\"a\"", "of one layer"));
  CHECK(names(refusal([] { collision::Layers{}; }), "number of names", "0", "from 1 to 32"));
}

TEST_CASE("layers: shards fall through each other and lie on the ground", "[scene][layers]") {
  collision::Layers layers{"room", "debris"};
  layers.ignore("debris", "debris");
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static, .filter = layers["room"]});
  const SolidDef shard{.pose = {.position = Vec3(0.0, 0.0, 0.2)}, .filter = layers["debris"]};
  const BodyId a = scene.add(Sphere{0.1}, shard);
  const BodyId b = scene.add(Sphere{0.1}, shard);
  for (int i = 0; i < 60; ++i) scene.step(1.0 / 60.0);
  CHECK(scene.pose(a).position.z() == Approx(0.1).margin(1e-3));
  CHECK((scene.pose(a).position - scene.pose(b).position).norm() < 1e-9);
}

}  // namespace layers_test
