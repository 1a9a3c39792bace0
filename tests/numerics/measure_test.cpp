// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What the benchmarks measure with is right itself.

#include <numbers>

#include "measure/geometry.h"
#include "measure/quality.h"
#include "numerics/track.h"
#include "scenes/random.h"
#include "support/catch.h"

namespace measure_test {

using namespace tandem::bench;

namespace {

/// An engine that stands where it is told to.
class Still final : public Engine {
 public:
  explicit Still(const Scene& scene) {
    for (const SceneBody& body : scene.bodies) states.push_back({body.pose, body.twist});
  }
  std::string name() const override { return "still"; }
  void step(double /*dt*/) override {}
  tandem::pbd::BodyState state(int body) const override {
    return states[static_cast<std::size_t>(body)];
  }
  bool awake(int /*body*/) const override { return false; }
  void set_twist(int /*body*/, const Twist& /*twist*/) override {}
  void set_pose(int /*body*/, const Pose& /*pose*/) override {}
  void touching(std::vector<std::pair<int, int>>& /*out*/) const override {}
  std::vector<tandem::pbd::BodyState> states;
};

}  // namespace

TEST_CASE("measure: boxes overlap by the depth that they were moved", "[measure]") {
  SceneRandom random;
  const Vec3 half_a(0.5, 0.3, 0.2);
  const Vec3 half_b(0.4, 0.2, 0.6);
  for (int i = 0; i < 200; ++i) {
    // Face to face along x of a frame that lies anywhere: the depth is known.
    const Quat q = random.orientation(3.0);
    const double depth = 0.1 * random.u() - 0.05;
    const Pose a{.position = Vec3(1.0, 2.0, 3.0), .orientation = q};
    const Pose b{.position = a.position + q * Vec3(0.9 - depth, 0.05, 0.1), .orientation = q};
    CHECK(box_box_gap(half_a, a, half_b, b) == Approx(-depth).margin(1e-12));
  }
}

TEST_CASE("measure: two crossed edges overlap along the axis across both", "[measure]") {
  // Cubes turned by 45 degrees about x and about y: edges along x and y face each other along z.
  const Vec3 half = Vec3::Constant(0.5);
  const Pose a{.position = Vec3::Zero(),
               .orientation = tandem::pbd::exp_map(Vec3(std::numbers::pi / 4.0, 0.0, 0.0))};
  const double reach = std::sqrt(0.5);
  for (const double gap : {-0.05, 0.02}) {
    const Pose b{.position = Vec3(0.0, 0.0, 2.0 * reach + gap),
                 .orientation = tandem::pbd::exp_map(Vec3(0.0, std::numbers::pi / 4.0, 0.0))};
    CHECK(box_box_gap(half, a, half, b) == Approx(gap).margin(1e-12));
  }
}

TEST_CASE("measure: a box's lowest corner counts against the floor", "[measure]") {
  const Vec3 floor_half(50.0, 50.0, 1.0);
  const Pose floor = at(0.0, 0.0, -1.0);
  // On its corner: the half diagonal reaches down.
  const Quat corner = Quat(Eigen::Quaterniond::FromTwoVectors(Vec3::Ones(), Vec3::UnitZ()));
  const Pose pose{.position = Vec3(3.0, 4.0, std::sqrt(0.75) - 0.01), .orientation = corner};
  CHECK(box_wall_gap(Vec3::Constant(0.5), pose, floor_half, floor) == Approx(-0.01).margin(1e-12));
}

TEST_CASE("measure: distance to a triangle is the least over a fine grid of it", "[measure]") {
  SceneRandom random;
  const auto point = [&] { return Vec3(random.u(), random.u(), random.u()); };
  for (int i = 0; i < 50; ++i) {
    const Vec3 a = point(), b = point(), c = point();
    const Vec3 p = 2.0 * point() - Vec3::Constant(0.5);
    double least = HUGE_VAL;
    constexpr int kGrid = 200;
    for (int u = 0; u <= kGrid; ++u) {
      for (int v = 0; v <= kGrid - u; ++v) {
        const Vec3 on = a + (b - a) * u / kGrid + (c - a) * v / kGrid;
        least = std::min(least, (on - p).norm());
      }
    }
    const double found = (closest_on_triangle(p, a, b, c) - p).norm();
    CHECK(found <= least + 1e-12);
    CHECK(found >= least - 0.02);
  }
}

TEST_CASE("measure: the cliff's surface has the formula's height at its corners", "[measure]") {
  const Scene scene = peer_scene("cliff");
  const HeightSurface surface(*std::get<MeshShape>(scene.bodies[0].shape));
  for (int i = -31; i < 32; i += 3) {
    const double x = 0.375 * i;
    const double y = -0.375 * i;
    CHECK(surface.height(x, y).value() == Approx(cliff_height(x, y)).margin(1e-9));
  }
  CHECK_FALSE(surface.height(12.5, 0.0).has_value());
  CHECK(surface.distance(Vec3(-6.0, 0.0, cliff_height(-6.0, 0.0) - 0.1)).value() < 0.0);
}

TEST_CASE("measure: overlap, pairs and tunnelling of a scene set by hand", "[measure]") {
  Scene scene;
  scene.name = "heap";
  scene.seconds = 0.5;
  scene.add_static(BoxShape{Vec3(50.0, 50.0, 1.0)}, at(0.0, 0.0, -1.0));
  scene.add(cube(1.0), 1.0, at(0.0, 0.0, 0.49));   // 10 mm in the floor
  scene.add(cube(1.0), 1.0, at(0.0, 0.0, 1.47));   // 20 mm in the one below
  scene.add(cube(1.0), 1.0, at(0.0, 0.0, 2.474));  // 4 mm of gap: touches
  scene.add(cube(1.0), 1.0, at(4.0, 0.0, 0.506));  // 6 mm of gap: does not
  const Still engine(scene);
  PenetrationProbe probe(scene);
  const Penetration found = probe.measure(engine);
  CHECK(found.pairs == 3);
  CHECK(found.max == Approx(0.02).margin(1e-12));
  CHECK(found.mean == Approx(0.01).margin(1e-12));
}

TEST_CASE("measure: a ball below the cliff's surface has tunnelled", "[measure]") {
  const Scene scene = peer_scene("cliff");
  Still engine(scene);
  Quality quality(scene, engine, {});
  engine.states[5].pose.position = Vec3(-5.0, 1.0, cliff_height(-5.0, 1.0) - 0.3);
  engine.states[6].pose.position = Vec3(-5.0, 3.0, cliff_height(-5.0, 3.0) - 0.05);  // only deep
  engine.states[7].pose.position = Vec3(20.0, 0.0, -30.0);                           // beside
  quality.after_frame(0, engine);
  for (const auto& [name, value] : quality.finish(engine)) {
    if (name == "tunnelled") CHECK(value == 1.0);
    if (name == "left_mesh") CHECK(value == 1.0);
  }
}

TEST_CASE("measure: K of the elliptic integral, periods of known signals", "[measure]") {
  CHECK(elliptic_k(0.0) == Approx(std::numbers::pi / 2.0).epsilon(1e-14));
  CHECK(elliptic_k(std::sin(std::numbers::pi / 4.0)) == Approx(1.8540746773013719).epsilon(1e-14));
  std::vector<double> slow, fast;
  for (int i = 0; i < 600; ++i) {
    slow.push_back(std::cos(2.0 * std::numbers::pi * i / 60.0 / 1.7));
    fast.push_back(std::pow(0.99, i) * std::cos(2.0 * std::numbers::pi * i / 60.0 / 0.05));
  }
  CHECK(crossing_period(slow, 1.0 / 60.0) == Approx(1.7).epsilon(1e-4));
  CHECK(sinusoid_period(fast, 1.0 / 60.0) == Approx(0.05).epsilon(1e-9));
}

TEST_CASE("measure: the scenes have the bodies that other engines were given", "[measure]") {
  const std::vector<std::pair<std::string, std::size_t>> sizes{
      {"cliff", 1001}, {"stacks", 101}, {"katamari", 902}, {"chain", 51},
      {"heap", 8005},  {"ratio", 6},    {"pyramid", 121}};
  for (const auto& [name, size] : sizes) CHECK(peer_scene(name).bodies.size() == size);
  CHECK_THROWS_WITH(peer_scene("none"), Catch::Contains("none"));
  CHECK(peer_scene("chain").joints.size() == 51);
  // The generator's first numbers, computed by hand from the recurrence.
  SceneRandom random;
  std::uint64_t s = 0x9e3779b97f4a7c15ull;
  for (int i = 0; i < 5; ++i) {
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    CHECK(random.u() == static_cast<double>(s >> 33) / 2147483648.0);
  }
}

}  // namespace measure_test
