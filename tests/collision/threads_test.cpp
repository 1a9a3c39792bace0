// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Detection by many: who does what changes no bit, and under the thread sanitizer no two of them
// touch the same thing.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenes.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/workers.h"

namespace collision_threads_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::pbd::Solver;
using tandem::pbd::Workers;

TEST_CASE("threads: contacts are the same bits for any number of workers", "[collision][golden]") {
  std::vector<std::vector<std::byte>> found;
  for (const int count : {1, 2, 3}) {
    Fixture f;
    Workers workers(count);
    f.fixed(flat_mesh(20.0, 19));
    // Tiles flush with it, so that contacts with their sides are covered.
    for (int i = -3; i < 3; ++i) f.fixed(Box{Vec3(0.25, 2.0, 0.2)}, at(0.5 * i, 0.0, -0.2));
    Random random(8);
    const std::vector<Shape> shapes = convex_shapes(0.5);
    std::vector<BodyId> ids;
    for (int i = 0; i < 240; ++i) {
      const Vec3 p = random.vec(1.4) + Vec3(0, 0, 1.3);
      ids.push_back(f.add(shapes[static_cast<std::size_t>(i) % shapes.size()], {p, random.quat()}));
    }
    std::vector<std::byte> all;
    for (int step = 0; step < 25; ++step) {
      f.manifolds.clear();
      f.scene.collect(f.world, kDt, workers, f.manifolds);
      const auto bytes = bytes_of(f.manifolds);
      all.insert(all.end(), bytes.begin(), bytes.end());
      for (const BodyId id : ids) {  // some far, some hardly, some not at all
        if (id.index % 3 == 0) continue;
        Pose pose = f.world.pose(id);
        pose.position += (id.index % 3 == 1 ? 1e-3 : 3e-2) * random.vec(1.0);
        pose.orientation = (tandem::pbd::exp_map(random.vec(0.02)) * pose.orientation).normalized();
        f.world.set_pose(id, pose);
      }
    }
    CHECK(f.manifolds.size() > 500);
    found.push_back(all);
  }
  CHECK(found[0] == found[1]);
  CHECK(found[0] == found[2]);
}

TEST_CASE("threads: a heap has the same bits on one, two, three and eight threads",
          "[collision][unit]") {
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 3, 8}) {
    Fixture f;
    f.fixed(HalfSpace{});
    Random random(5);
    for (int i = 0; i < 150; ++i) {
      const Vec3 p(0.24 * (i % 5), 0.24 * (i / 5 % 5), 0.2 + 0.24 * (i / 25));
      const BodyId box = f.world.add_body({.pose = {p, random.quat()}});
      f.scene.add(f.world, {.body = box, .shape = Box{Vec3::Constant(0.1)}});
    }
    f.world.set_contact_source(&f.scene);
    Solver solver({.threads = threads});
    for (int step = 0; step < 90; ++step) (void)solver.step(f.world, kDt);
    hashes.push_back(f.world.hash());
  }
  for (const std::uint64_t hash : hashes) CHECK(hash == hashes[0]);
}

}  // namespace collision_threads_test
