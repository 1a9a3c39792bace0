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

TEST_CASE("threads: contacts stay those of one thread as a world gets smaller",
          "[collision][unit]") {
  std::vector<std::vector<std::byte>> expected;
  for (const int threads : {1, 2, 4}) {
    Fixture f;
    f.fixed(HalfSpace{});
    std::vector<BodyId> boxes;
    for (int i = 0; i < 900; ++i) {
      boxes.push_back(f.add(Box{Vec3::Constant(0.1)}, at(0.5 * (i % 30), 0.5 * (i / 30), 0.1001)));
    }
    f.world.set_contact_source(&f.scene);
    Solver solver({.threads = threads});
    std::size_t step = 0;
    const auto run = [&](int steps, std::size_t contacts) {
      for (int k = 0; k < steps; ++k, ++step) {
        solver.step(f.world, kDt);
        CHECK(f.world.contacts()->contacts().size() == contacts);
        if (threads == 1) {
          expected.push_back(f.world.snapshot());
        } else if (f.world.snapshot() != expected[step]) {
          FAIL(threads << " threads part from one in step " << step);
        }
      }
    };
    run(3, 900);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (i % 3 != 0) f.world.remove_body(boxes[i]);
    }
    run(3, 300);
  }
}

TEST_CASE("threads: blows pass through a large island by the same bits", "[collision][unit]") {
  std::vector<std::uint64_t> expected;
  for (const int threads : {1, 2, 4}) {
    Fixture f;
    const tandem::collision::Material bouncy{.restitution = 0.6};
    const BodyId ground = f.world.add_body({.type = tandem::pbd::BodyType::Static});
    f.scene.add(f.world, {.body = ground, .shape = HalfSpace{}, .material = bouncy});
    for (int i = 0; i < 2400; ++i) {
      tandem::pbd::BodyDef def{
          .pose = at(0.2 * (i % 20), 0.2 * (i / 20 % 20), 0.101 + 0.2 * (i / 400))};
      def.twist.linear = Vec3(0.01 * (i % 7), 0.013 * (i % 5), -3.0 - 0.01 * (i % 11));
      f.scene.add(
          f.world,
          {.body = f.world.add_body(def), .shape = Box{Vec3::Constant(0.1)}, .material = bouncy});
    }
    f.world.set_contact_source(&f.scene);
    Solver solver({.threads = threads});
    for (std::size_t step = 0; step < 3; ++step) {
      solver.step(f.world, kDt);
      CHECK(f.world.contacts()->contacts().size() > 4096);
      if (threads == 1) {
        expected.push_back(f.world.hash());
      } else if (f.world.hash() != expected[step]) {
        FAIL(threads << " threads part from one in step " << step);
      }
    }
  }
}

}  // namespace collision_threads_test
