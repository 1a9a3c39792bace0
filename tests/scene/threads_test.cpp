// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A day's worth of things in one world, drawn at random: on any number of threads the bits are
// those of one.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/catch.h"
#include "tandem/cloth.h"
#include "tandem/pbd/random.h"
#include "tandem/ragdoll.h"
#include "tandem/rope.h"
#include "tandem/scene.h"

namespace scene_threads_test {

using namespace tandem;

namespace {

/// Balls, boxes, capsules and cylinders of many sizes, heaped or far apart, dolls, ropes, a cloth,
/// a platform that moves; bodies come, are hit and removed, and half way three of four go.
class Day {
 public:
  Day(std::uint64_t seed, int threads) : random_(seed), scene_(options(threads)) {
    add_ground();
    const double spread = random_.uniform(0.5, 12.0);  // m
    const auto count = static_cast<int>(random_.uniform(50.0, 900.0));
    for (int i = 0; i < count; ++i) add_solid(spread);
    for (std::uint64_t i = random_.below(6); i > 0; --i) {
      Ragdoll(scene_, {.pose = {.position = place(spread, 3.0)}});
    }
    for (std::uint64_t i = random_.below(4); i > 0; --i) {
      const Vec3 from = place(spread, 2.0);
      Rope(scene_, {.from = from, .to = from + Vec3(1.0, 0.2, 0.0)});
    }
    if (random_.chance(0.5))
      Cloth(scene_, {.pose = {.position = place(spread, 2.5)}, .columns = 8, .rows = 8});
    dt_ = random_.chance(0.5) ? 1.0 / 60.0 : random_.uniform(1.0 / 144.0, 1.0 / 30.0);
  }

  /// @return the hash after it; 0 where something was no number
  std::uint64_t step() {
    if (++steps_ == 20) thin_out();
    for (std::uint64_t i = random_.below(3); i > 0; --i) {
      const std::size_t which = random_.below(solids_.size());
      const BodyId body = solids_[which];
      if (random_.chance(0.2)) {
        scene_.remove(body);
        solids_.erase(solids_.begin() + static_cast<std::ptrdiff_t>(which));
        if (solids_.size() < 10) add_solid(2.0);
      } else if (random_.chance(0.5)) {
        scene_.apply_impulse(body, Vec3(0.0, 0.0, random_.uniform(0.0, 5.0)));
      } else {
        add_solid(3.0);
      }
    }
    if (scene_.step(dt_).status != pbd::StepStatus::Ok) return 0;
    return scene_.world().hash();
  }

 private:
  static SceneOptions options(int threads) {
    SceneOptions options;
    options.solver.threads = threads;
    return options;
  }
  Vec3 place(double spread, double height) {
    return {random_.uniform(-spread, spread), random_.uniform(-spread, spread),
            random_.uniform(0.3, height)};
  }
  /// Most of them go at once.
  void thin_out() {
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      if (i % 4 != 0) scene_.remove(solids_[i]);
    }
    for (std::size_t i = 0; 4 * i < solids_.size(); ++i) solids_[i] = solids_[4 * i];
    solids_.resize((solids_.size() + 3) / 4);
  }
  void add_ground() {
    const double bounce = random_.chance(0.5) ? random_.uniform(0.0, 0.9) : 0.0;
    scene_.add(HalfSpace{}, {.type = BodyType::Static, .material = {.restitution = bounce}});
    if (random_.chance(0.5)) {
      pbd::Twist twist;
      twist.linear = Vec3(random_.uniform(-1.0, 1.0), 0.0, random_.uniform(-0.1, 0.1));
      scene_.add(
          Box{1.0, 1.0, 0.1},
          {.type = BodyType::Kinematic, .pose = {.position = {0.0, 0.0, 0.2}}, .twist = twist});
    }
  }
  void add_solid(double spread) {
    const double size = 0.02 * std::pow(10.0, random_.unit());  // m
    SolidDef def{.density = random_.uniform(100.0, 8000.0),
                 .pose = {.position = place(spread, 4.0)},
                 .material = {.friction = random_.uniform(0.0, 1.0),
                              .restitution = random_.chance(0.2) ? 0.5 : 0.0}};
    def.twist.linear = Vec3(random_.uniform(-2.0, 2.0), 0.0, random_.uniform(-2.0, 2.0));
    switch (random_.below(4)) {
      case 0:
        solids_.push_back(scene_.add(Sphere{size}, def));
        break;
      case 1:
        solids_.push_back(scene_.add(Capsule{size, 2.0 * size}, def));
        break;
      case 2:
        solids_.push_back(scene_.add(Cylinder{size, 2.0 * size}, def));
        break;
      default:
        solids_.push_back(scene_.add(Box{size, 2.0 * size, size}, def));
        break;
    }
  }

  pbd::SplitMix64 random_;
  Scene scene_;
  std::vector<BodyId> solids_;
  double dt_ = 0.0;  ///< s
  int steps_ = 0;
};

}  // namespace

TEST_CASE("threads: any scene has the bits of one thread", "[scene][unit]") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::vector<std::uint64_t> expected;
    for (const int threads : {1, 2, 3, 8}) {
      CAPTURE(seed, threads);
      Day day(seed, threads);
      std::vector<std::uint64_t> hashes;
      for (int step = 0; step < 40; ++step) hashes.push_back(day.step());
      CHECK(std::count(hashes.begin(), hashes.end(), 0u) == 0);
      if (threads == 1) expected = hashes;
      CHECK(hashes == expected);
    }
  }
}

}  // namespace scene_threads_test
