// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/character.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "collision/allocation_count.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace character_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kStep = 1.0 / 60.0;
constexpr double kG = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;
const CharacterDef kDef;
/// m, middle of the capsule above the ground that it stands on.
const double kHeight = kDef.shape.half_height + kDef.shape.radius + kDef.padding;

/// A character at `position` on the plane z = 0.
struct Place {
  explicit Place(CharacterDef def = kDef, const Vec3& position = {0.0, 0.0, kHeight},
                 double friction = 0.5)
      : hero(scene, with(def, position)) {
    scene.add(HalfSpace{}, {.type = BodyType::Static, .material = {.friction = friction}});
  }
  static CharacterDef with(CharacterDef def, const Vec3& position) {
    def.position = position;
    return def;
  }
  void run(double seconds, const Vec3& velocity, const std::function<void()>& each = {}) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kStep)); ++i) {
      hero.walk(velocity, kStep);
      scene.step(kStep);
      if (each) each();
    }
  }
  Vec3 at() const { return scene.pose(hero.body()).position; }
  BodyId solid(const Box& box, const Vec3& position) {
    return scene.add(box, {.type = BodyType::Static, .pose = {.position = position}});
  }

  Scene scene;
  Character hero;
};

void add_stairs(Place& place, int count, double rise, double tread) {
  for (int i = 0; i < count; ++i) {
    const double top = rise * (i + 1);
    const double length = tread * (count - i) + 6.0;
    place.solid(Box{0.5 * length, 2.0, 0.5 * top},
                {1.0 + tread * i + 0.5 * length, 0.0, 0.5 * top});
  }
}

TEST_CASE("character: stairs are walked up and down without leaving the ground", "[character]") {
  const double rise = GENERATE(0.1, 0.2, 0.34);
  Place place;
  add_stairs(place, 10, rise, 0.3);
  bool on_ground = true;
  const auto watch = [&] { on_ground = on_ground && place.hero.footing() == Footing::Ground; };
  place.run(0.1, Vec3::Zero());
  place.run(5.0, {1.5, 0.0, 0.0}, watch);
  CHECK(on_ground);
  CHECK(place.at().z() == Approx(10 * rise + kHeight).margin(1e-3));
  CHECK(place.at().x() > 0.75 * 7.5);  // stairs cost some of the way
  place.run(6.0, {-1.5, 0.0, 0.0}, watch);
  CHECK(on_ground);
  CHECK(place.at().z() == Approx(kHeight).margin(1e-3));
}

TEST_CASE("character: a step is climbed up to its limit and not beyond", "[character]") {
  const double over = GENERATE(-0.01, 0.01);
  Place place;
  add_stairs(place, 1, kDef.max_step + over, 1.0);
  place.run(2.0, {2.0, 0.0, 0.0});
  if (over < 0.0) {
    CHECK(place.at().z() == Approx(kHeight + kDef.max_step + over).margin(1e-3));
  } else {
    CHECK(place.at().z() == Approx(kHeight).margin(1e-3));
    CHECK(place.at().x() == Approx(1.0 - kDef.shape.radius - kDef.padding).margin(2e-3));
  }
}

/// A half-space that rises along x by `angle`, through the origin, and a character on it.
struct Slope {
  explicit Slope(double angle)
      : normal(-std::sin(angle), 0.0, std::cos(angle)), hero(scene, on(normal)) {
    scene.add(HalfSpace{.normal = normal}, {.type = BodyType::Static});
  }
  static CharacterDef on(const Vec3& normal) {
    CharacterDef def;
    const double clear = def.shape.radius + def.padding;
    def.position = clear * normal + def.shape.half_height * Vec3::UnitZ();
    return def;
  }
  void run(double seconds, const Vec3& velocity) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kStep)); ++i) {
      hero.walk(velocity, kStep);
      scene.step(kStep);
    }
  }
  Vec3 at() const { return scene.pose(hero.body()).position; }

  Vec3 normal;
  Scene scene;
  Character hero;
};

TEST_CASE("character: slopes are walked up to the limit less a degree", "[character]") {
  const double angle = kDef.max_slope - GENERATE(1.0, 20.0) * kDegree;
  Slope slope(angle);
  slope.run(0.5, Vec3::Zero());
  const Vec3 start = slope.at();
  slope.run(2.0, Vec3::Zero());
  CHECK((slope.at() - start).norm() < 1e-9);  // stands
  slope.run(2.0, {1.0, 0.0, 0.0});
  CHECK(slope.hero.footing() == Footing::Ground);
  CHECK(slope.at().x() - start.x() == Approx(2.0).epsilon(1e-3));
  CHECK(slope.at().z() - start.z() == Approx(2.0 * std::tan(angle)).epsilon(1e-3));
  slope.run(2.0, {-1.0, 0.0, 0.0});
  CHECK((slope.at() - start).norm() < 5e-3);  // down is the same way
}

TEST_CASE("character: a degree more is slid down like a ramp without friction", "[character]") {
  const double angle = kDef.max_slope + 1.0 * kDegree;
  Slope slope(angle);
  slope.run(0.2, Vec3::Zero());
  const double speed = -slope.hero.velocity().z();
  slope.run(0.5, Vec3::Zero());
  CHECK(slope.hero.footing() == Footing::Steep);
  const double down = kG * std::sin(angle) * std::sin(angle);  // m/s^2
  CHECK(-slope.hero.velocity().z() - speed == Approx(0.5 * down).epsilon(0.02));

  Slope other(angle);
  other.run(0.2, Vec3::Zero());
  const Vec3 start = other.at();
  double highest = start.z();
  for (int i = 0; i < 60; ++i) {
    other.run(kStep, {3.0, 0.0, 0.0});
    highest = std::max(highest, other.at().z());
  }
  CHECK(highest <= start.z() + 1e-6);  // no way up
}

TEST_CASE("character: platforms carry it, however they move", "[character]") {
  Place place;
  const Box deck{2.0, 2.0, 0.25};
  const Pose start{Vec3(0.0, 0.0, -2.0), Quat::Identity()};
  const auto way = [&](double t) {
    return Pose{start.position +
                    Vec3(6.0 * std::sin(t), 2.0 * (1.0 - std::cos(t)), 1.5 * std::sin(1.7 * t)),
                Quat(Eigen::AngleAxisd(0.8 * t, Vec3::UnitZ()))};
  };
  Scene scene;
  const BodyId platform = scene.add(deck, {.type = BodyType::Kinematic, .pose = start});
  CharacterDef def;
  def.position = start.position + Vec3(1.0, 0.5, deck.half_extents.z() + kHeight);
  Character hero(scene, def);
  const auto there = [&] {
    return scene.pose(platform).to_local(scene.pose(hero.body()).position);
  };
  hero.walk(Vec3::Zero(), kStep);
  scene.step(kStep);
  const Vec3 first = there();
  double drift = 0.0;
  for (int i = 1; i < 600; ++i) {
    scene.world().set_kinematic_target(platform, way(i * kStep));
    hero.walk(Vec3::Zero(), kStep);
    scene.step(kStep);
    drift = std::max(drift, (there() - first).norm());
    REQUIRE(hero.ground() == platform);
  }
  CHECK(drift < 1e-3);
}

TEST_CASE("character: a wall of its support does not stop it", "[character]") {
  Scene scene;
  std::vector<collision::CompoundPart> parts(2);
  parts[0].shape = Box{3.0, 1.0, 0.1};
  parts[1].shape = Box{0.1, 1.0, 1.0};
  parts[1].local.position = Vec3(1.0, 0.0, 1.0);
  const BodyId train = scene.add(
      parts, {.type = BodyType::Kinematic, .twist = {Vec3(20.0, 0.0, 0.0), Vec3::Zero()}});
  CharacterDef def;
  def.position = Vec3(0.5, 0.0, 0.1 + kHeight);
  Character hero(scene, def);
  const auto there = [&] {
    return (scene.pose(hero.body()).position - scene.pose(train).position).eval();
  };
  hero.walk(Vec3::Zero(), kStep);
  scene.step(kStep);
  const Vec3 first = there();
  for (int i = 0; i < 120; ++i) {
    hero.walk(Vec3::Zero(), kStep);
    scene.step(kStep);
  }
  CHECK((there() - first).norm() < 1e-6);
}

TEST_CASE("character: a jump rises by v^2 / 2g, and no further than the ceiling", "[character]") {
  Place open;
  open.run(0.1, Vec3::Zero());
  double top = 0.0;
  open.hero.jump(4.0);
  open.run(1.5, Vec3::Zero(), [&] {
    top = std::max(top, open.at().z() - kHeight);
    CHECK(open.hero.ground().valid() == (open.hero.footing() == Footing::Ground));
  });
  CHECK(top == Approx(4.0 * 4.0 / (2.0 * kG)).epsilon(2e-3));  // seen once in a step
  CHECK(open.hero.footing() == Footing::Ground);

  Place low;
  low.solid(Box{5.0, 5.0, 0.1}, {0.0, 0.0, 2.0 * kHeight + 0.3 + 0.1});
  low.run(0.1, Vec3::Zero());
  double highest = 0.0;
  int in_air = 0;
  low.hero.jump(4.0);
  low.run(1.5, Vec3::Zero(), [&] {
    highest = std::max(highest, low.at().z() - kHeight);
    if (low.hero.footing() == Footing::Air) ++in_air;
  });
  CHECK(highest == Approx(0.3).margin(1e-3));
  // Up to the ceiling, without the speed that it takes, and down: (v - sqrt(v^2 - 2 g h)) / g and
  // sqrt(2 h / g).
  const double expected = (4.0 - std::sqrt(16.0 - 0.6 * kG)) / kG + std::sqrt(0.6 / kG);
  CHECK(in_air * kStep == Approx(expected).margin(2.5 * kStep));
}

TEST_CASE("character: corners hold it and it does not tremble", "[character]") {
  const double angle = GENERATE(90.0, 60.0, 30.0) * kDegree;  // between the walls
  Place place(kDef, {-2.0, 0.0, kHeight});
  for (const double side : {-1.0, 1.0}) {
    const Vec3 along(-std::cos(0.5 * angle), side * std::sin(0.5 * angle), 0.0);
    const Vec3 out(std::sin(0.5 * angle), side * std::cos(0.5 * angle), 0.0);
    place.scene.add(
        Box{3.0, 0.2, 2.0},
        {.type = BodyType::Static,
         .pose = {3.0 * along + 0.2 * out,
                  Quat(Eigen::AngleAxisd(std::atan2(along.y(), along.x()), Vec3::UnitZ()))}});
  }
  place.run(4.0, {3.0, 0.4, 0.0});
  const Vec3 held = place.at();
  const double clear = kDef.shape.radius + kDef.padding;
  CHECK(-held.x() * std::sin(0.5 * angle) >= clear - std::abs(held.y()) - 0.01);
  CHECK(held.x() == Approx(-clear / std::sin(0.5 * angle)).margin(0.02));
  place.run(1.0, {3.0, 0.4, 0.0}, [&] { CHECK((place.at() - held).norm() < 1e-3); });
  CHECK(place.hero.footing() == Footing::Ground);
}

struct Pushed {
  Pushed(double mass, double friction, double speed, double max_push)
      : place(with_push(max_push), {0.0, 0.0, kHeight}, friction) {
    box = place.scene.add(Box{1.0, 1.0, 1.0},
                          {.mass = mass,
                           .pose = {.position = {1.0 + kDef.shape.radius + kDef.padding, 0.0, 1.0}},
                           .twist = {Vec3(speed, 0.0, 0.0), Vec3::Zero()},
                           .material = {.friction = friction}});
  }
  static CharacterDef with_push(double max_push) {
    CharacterDef def;
    def.max_push = max_push;
    return def;
  }
  double speed() const { return place.scene.world().twist(box).linear.x(); }
  Place place;
  BodyId box;
};

TEST_CASE("character: it pushes with max_push against friction", "[character]") {
  const double weight = 200.0 * kG;
  Pushed stuck(200.0, 1.1 * 400.0 / weight, 0.0, 400.0);
  stuck.place.run(2.0, {3.0, 0.0, 0.0});
  CHECK(stuck.place.scene.pose(stuck.box).position.x() == Approx(1.32).margin(5e-3));

  Pushed moves(200.0, 0.5 * 400.0 / weight, 0.0, 400.0);
  moves.place.run(1.0, {3.0, 0.0, 0.0});
  CHECK(moves.speed() == Approx(1.0 * 200.0 / 200.0).epsilon(0.05));  // (F - mu m g) t / m

  Pushed light(10.0, 0.1, 0.0, 400.0);
  light.place.run(2.0, {1.5, 0.0, 0.0});
  CHECK(light.speed() == Approx(1.5).epsilon(0.1));
  CHECK(light.place.hero.velocity().x() == Approx(1.5).epsilon(0.05));
}

TEST_CASE("character: a body that runs into it takes it along, and momentum is kept",
          "[character]") {
  const double mass = GENERATE(30.0, 1000.0);
  Pushed hit(mass, 0.0, -2.0, 0.0);
  hit.place.run(1.0, Vec3::Zero());
  const double common = -2.0 * mass / (mass + kDef.mass);
  CHECK(hit.speed() == Approx(common).epsilon(0.01));
  CHECK(hit.place.hero.velocity().x() == Approx(common).epsilon(0.01));

  Pushed held(mass, 0.0, -2.0, 400.0);  // and its legs hold against it
  double slowest = 0.0;
  double last = 0.0;
  held.place.run(1.0, Vec3::Zero(), [&] {
    if (last != 0.0) slowest = std::max(slowest, (held.speed() - last) / kStep);
    last = held.speed();
  });
  CHECK(slowest <= 400.0 / mass * 1.05);
  CHECK(slowest >= 400.0 / mass * 0.9);
}

TEST_CASE("character: its ground bears its weight", "[character]") {
  Place place(kDef, {0.0, 0.0, 2.0 + kHeight});
  // A raft on a spring that cannot tip: m g / k further down with a character on it.
  const double k = 20000.0;
  const BodyId raft =
      place.scene.add(Box{1.0, 1.0, 0.1}, {.mass = 50.0,
                                           .pose = {.position = {0.0, 0.0, 1.9}},
                                           .linear_damping = 3.0,
                                           .locks = {.angular = {true, true, true}}});
  pbd::SliderJointDef guide =
      pbd::slider_joint_at(place.scene.world(), {}, raft, Vec3(0.0, 0.0, 1.9), Vec3::UnitZ());
  guide.axis.spring = {.stiffness = k, .damping = 500.0};
  place.scene.add_joint(guide);
  place.run(4.0, Vec3::Zero());
  REQUIRE(place.hero.ground() == raft);
  const double expected = 1.9 - (50.0 + kDef.mass) * kG / k;
  CHECK(place.scene.pose(raft).position.z() == Approx(expected).margin(2e-3));
}

TEST_CASE("character: without push it never adds energy", "[character]") {
  CharacterDef def;
  def.max_push = 0.0;
  Place place(def, {0.0, 0.0, kHeight}, 0.0);
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.9 * i;
    const double away = 1.0 + 0.3 * i;
    const Vec3 from(away * std::cos(angle), away * std::sin(angle), 0.5 + 0.1 * i);
    place.scene.add(
        Box{0.2, 0.15, 0.1},
        {.mass = 2.0 + 12.0 * i,
         .pose = {from, Quat(Eigen::AngleAxisd(angle, Vec3(1.0, 2.0, 3.0).normalized()))},
         .twist = {-1.5 * from.normalized() * (1.0 + 0.2 * i), Vec3(1.0, 0.0, 2.0)}});
  }
  const auto energy = [&] {
    const Vec3 v = place.hero.velocity();
    return place.scene.world().mechanical_energy() + 0.5 * def.mass * v.squaredNorm() +
           def.mass * kG * (place.at().z() - kHeight);
  };
  const double first = energy();
  double most = first;
  double moved = 0.0;
  place.run(5.0, Vec3::Zero(), [&] {
    most = std::max(most, energy());
    moved = std::max(moved, place.at().head<2>().norm());
  });
  CHECK(moved > 0.5);  // it was hit
  CAPTURE(most, first, moved);
  CHECK(most <= first * (1.0 + 1e-3));
}

TEST_CASE("character: walking allocates nothing once sizes are known", "[character]") {
  Pushed crowd(10.0, 0.3, -1.0, 400.0);
  add_stairs(crowd.place, 3, 0.2, 0.3);
  const auto round = [&] {
    crowd.place.hero.walk({1.0, 0.3, 0.0}, kStep);
    crowd.place.scene.step(kStep);
  };
  for (int i = 0; i < 240; ++i) round();
  const collision::testing::AllocationCount count;
  for (int i = 0; i < 120; ++i) round();
  CHECK(count.count() == 0);
}

TEST_CASE("character: errors name field, value and rule", "[character]") {
  Scene scene;
  const auto make = [&](CharacterDef def) { return refusal([&] { Character(scene, def); }); };
  CHECK(names(make({.mass = 0.0}), "mass", "0", "> 0"));
  CHECK(names(make({.max_push = -1.0}), "max_push", "-1", ">= 0"));
  CHECK(names(make({.max_slope = 1.6}), "max_slope", "1.6", "1.5"));
  CHECK(names(make({.max_step = -1.0}), "max_step", "-1", ">= 0"));
  CHECK(names(make({.air_acceleration = -1.0}), "air_acceleration", "-1", ">= 0"));
  CHECK(names(make({.padding = 0.3}), "padding", "0.3", "radius"));
  CHECK(scene.world().body_count() == 0);
  Character hero(scene, {});
  CHECK(names(refusal([&] { hero.walk(Vec3::Zero(), 0.0); }), "dt", "0", "> 0"));
  CHECK(
      names(refusal([&] { hero.walk(Vec3::Constant(NAN), kStep); }), "velocity", "nan", "finite"));
  CHECK(names(refusal([&] { hero.jump(-1.0); }), "speed", "-1", ">= 0"));
  hero.walk(Vec3::Zero(), kStep);
  CHECK(hero.footing() == Footing::Air);
  CHECK_FALSE(hero.ground().valid());
  CHECK(hero.ground_normal() == Vec3::UnitZ());
}

}  // namespace character_test
