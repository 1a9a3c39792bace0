// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <array>

#include "fixture.h"
#include "support/forged.h"

namespace forged_snapshot_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::testing::forged;
using tandem::testing::survives;

namespace {

/// Pairs of most kinds: boxes, a ball, a capsule, two meshes side by side, a half-space.
struct Scene {
  Fixture f;
  tandem::pbd::Solver solver;

  Scene() {
    f.fixed(HalfSpace{});
    f.fixed(flat_mesh(2.0, 2), at(5.0, 0.0, 0.5));
    f.add(box_mesh(Vec3::Constant(0.25)), at(5.0, 0.0, 1.5));
    for (int i = 0; i < 3; ++i) f.add(Box{Vec3::Constant(0.25)}, at(0.1 * i, 0.0, 0.25 + 0.5 * i));
    f.add(Sphere{0.2}, at(0.6, 0.0, 0.2));
    f.add(Capsule{0.1, 0.2}, at(5.5, 0.0, 0.7));
    f.world.set_contact_source(&f.scene);
    for (int i = 0; i < 30; ++i) solver.step(f.world, kDt);
  }
};

}  // namespace

TEST_CASE("forged snapshot: no byte of a scene's caches breaks the world", "[collision][fault]") {
  Scene scene;
  const auto bytes = scene.f.world.snapshot();
  std::vector<std::byte> caches;
  tandem::pbd::ByteWriter out(caches);
  scene.f.scene.save(out);
  const std::size_t first = bytes.size() - tandem::testing::kCheckBytes - caches.size();
  int refusals = 0;
  for (std::size_t at = first; at < first + caches.size(); ++at) {
    for (const auto mask : {std::byte{0xff}, std::byte{0x01}}) {
      const std::array<std::byte, 1> other{bytes[at] ^ mask};
      INFO("byte " << at - first << " of " << caches.size());
      bool refused = false;
      REQUIRE(survives(scene.f.world, forged(bytes, at, other), refused));
      refusals += refused ? 1 : 0;
      if (!refused) scene.f.world.restore(bytes);
    }
  }
  CHECK(refusals > 100);
}

TEST_CASE("forged snapshot: a world with fewer bodies than the scene needs is refused",
          "[collision][fault]") {
  // The same colliders on the same slots; the other world has lost the last body, not its collider.
  Scene scene;
  Scene other;
  tandem::pbd::World bare;
  bare.set_contact_source(&other.f.scene);
  bool refused = false;
  CHECK(survives(scene.f.world, bare.snapshot(), refused));
  CHECK(refused);
}

}  // namespace forged_snapshot_test
