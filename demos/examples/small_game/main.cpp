// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A small game without graphics. Two players, each with their own world, 28.5 ms apart. The first
// walks through a door and into a stack of boxes; the second drives the car. Nobody owns doors,
// boxes or cars.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "tandem/car.h"
#include "tandem/character.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/session.h"

using namespace tandem;

constexpr double kStep = 1.0 / 60.0;  // s
constexpr int kPlayers = 2;

/// A driver's controls as the bytes of an event: all peers know the driver, so all of them drive
/// the car.
using Said = std::array<double, 3>;  // throttle, steer, brake

std::optional<Car::Controls> controls_of(std::span<const std::byte> bytes) {
  Said said;
  if (bytes.size() != sizeof said) return std::nullopt;
  std::memcpy(said.data(), bytes.data(), sizeof said);
  const auto [throttle, steer, brake] = said;
  // Input from other peers is untrusted.
  if (!(std::abs(throttle) <= 1.0 && std::abs(steer) <= 0.5 && brake >= 0.0 && brake <= 1.0)) {
    return std::nullopt;
  }
  return Car::Controls{.throttle = throttle, .steer = steer, .brake = brake};
}

/// One player's copy of everything.
struct Player {
  Player(PeerId number, consensus::VirtualNetwork& network)
      : self(number),
        session(scene, network.transport(number), {.clock = [&network] { return network.now(); }}) {
    build_house();
    for (int i = 0; i < 3; ++i) {
      share("box " + std::to_string(i),
            boxes[i] = scene.add(Box{0.25, 0.25, 0.25},
                                 {.mass = 4.0, .pose = at(4.0, 0.0, 0.25 + 0.5 * i)}));
    }
    share("chassis", car.chassis());
    for (int i = 0; i < 4; ++i) share("wheel " + std::to_string(i), car.wheels()[i]);
    for (PeerId i = 1; i <= kPlayers; ++i) {
      // The player's own hero walks; the others' heroes follow their events.
      heroes[i - 1] = i == self ? hero.body()
                                : scene.add(hero_shape(), {.type = BodyType::Kinematic,
                                                           .pose = {.position = home(i)}});
      session.share("hero " + std::to_string(i), heroes[i - 1], i);
    }
  }

  static Pose at(double x, double y, double z) { return {.position = Vec3(x, y, z)}; }
  static Capsule hero_shape() { return CharacterDef{}.shape; }
  static Vec3 home(PeerId player) { return {0.0, 2.0 * (static_cast<double>(player) - 1.0), 1.0}; }
  void share(const std::string& name, BodyId body) { session.share(name, body); }

  /// A wall with a self-closing door.
  void build_house() {
    scene.add(HalfSpace{}, {.type = BodyType::Static});
    for (const double y : {-1.26, 1.26}) {
      scene.add(Box{0.05, 0.75, 1.0}, {.type = BodyType::Static, .pose = at(2.0, y, 1.0)});
    }
    door = scene.add(Box{0.04, 0.48, 0.95}, {.mass = 15.0, .pose = at(2.0, 0.0, 0.98)});
    pbd::HingeJointDef hinge =
        pbd::hinge_joint_at(scene.world(), {}, door, Vec3(2.0, -0.48, 1.0), Vec3::UnitZ());
    hinge.axis = {.freedom = pbd::Freedom::Limited,
                  .lower = -1.9,
                  .upper = 1.9,
                  .spring = {.stiffness = 15.0, .damping = 8.0}};
    door_hinge = scene.add_joint(hinge);
    share("door", door);
  }

  void drive(const Car::Controls& controls) {
    const Said said{controls.throttle, controls.steer, controls.brake};
    session.events().send("drive", std::as_bytes(std::span(said)));
    car.drive(controls);
  }

  void play(const Vec3& walk, const std::optional<Car::Controls>& wheel) {
    session.advance(session.now(), [&](SessionTime) {
      for (const consensus::Event& event : session.events().received()) {
        if (event.topic != "drive") continue;
        if (const auto controls = controls_of(event.payload)) car.drive(*controls);
      }
      if (wheel) drive(*wheel);
      hero.walk(walk, kStep);
    });
  }

  double door_angle() { return scene.joints().hinge_angle(door_hinge); }
  Vec3 position(BodyId body) const { return scene.pose(body).position; }

  PeerId self;
  Scene scene;
  Session session;
  BodyId door;
  pbd::JointId door_hinge;
  std::array<BodyId, 3> boxes;
  std::array<BodyId, kPlayers> heroes;
  Car car{scene, {.pose = {.position = Vec3(0.0, 6.0, 0.8)}}};
  Character hero{scene, {.position = home(self)}};
};

int main() {
  consensus::VirtualNetwork network(consensus::network_profile(3), 1, 1'000'000'000);
  Player one(1, network), two(2, network);

  double opened = 0.0;
  for (int i = 0; i < 480; ++i) {
    const double time = i * kStep;
    network.advance_to(network.now() + 16'666'667);
    // Keeps walking straight, whatever the door does.
    const double aside = one.position(one.heroes[0]).y();
    one.play(time > 1.0 && time < 4.5 ? Vec3(1.4, -2.0 * aside, 0.0) : Vec3::Zero(), std::nullopt);
    std::optional<Car::Controls> wheel;
    if (i == 60) wheel = Car::Controls{.throttle = 0.4, .steer = 0.1};
    if (i == 240) wheel = Car::Controls{.brake = 1.0};
    two.play(Vec3::Zero(), wheel);
    opened = std::max(opened, std::abs(two.door_angle()));
    if (i % 60 == 59) {
      std::printf(
          "%.0f s: the second player sees the first one at x = %.2f m, the door at %.2f rad, "
          "the car at %.1f m/s\n",
          time + kStep, two.position(two.heroes[0]).x(), two.door_angle(), two.car.speed());
    }
  }

  double apart = (one.position(one.car.chassis()) - two.position(two.car.chassis())).norm();
  for (int i = 0; i < 3; ++i) {
    apart = std::max(apart, (one.position(one.boxes[i]) - two.position(two.boxes[i])).norm());
  }
  const double behind = (one.position(one.heroes[0]) - two.position(two.heroes[0])).norm();
  const bool kicked = (two.position(two.boxes[0]) - Vec3(4.0, 0.0, 0.25)).norm() > 0.05;
  const double way = (one.position(one.car.chassis()) - Vec3(0.0, 6.0, 0.8)).norm();
  std::printf(
      "the door was open by %.2f rad, the car went %.1f m; boxes and car are at most %.2g m "
      "apart, the first player %.2g m\n",
      opened, way, apart, behind);
  return opened > 0.5 && kicked && way > 5.0 && apart < 0.02 && behind < 0.02 ? 0 : 1;
}
