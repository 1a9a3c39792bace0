// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/room.h"

#include <cmath>
#include <utility>

#include "scenes/room_users.h"
#include "scenes/words.h"

namespace tandem::demos {

namespace {

using pbd::Vec3;

collision::Material rough() {
  collision::Material material;
  material.friction = 0.55;
  return material;
}

void add(SceneBuilder& builder, const std::string& name, const collision::Shape& shape, double mass,
         const pbd::Pose& pose) {
  BodySpec spec;
  spec.name = name;
  spec.parts = one_part(shape);
  spec.mass = mass;
  spec.pose = pose;
  spec.material = rough();
  builder.add(std::move(spec));
}

/// A truncated pyramid with six sides; the base is at z = 0.
collision::Hull hull_toy() {
  std::vector<Vec3> points;
  for (int i = 0; i < 6; ++i) {
    const double angle = 1.0471975511965976 * i;
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    points.push_back(0.08 * out);
    points.push_back(0.04 * out + Vec3(0.0, 0.0, 0.1));
  }
  return collision::ConvexHull::make(points);
}

/// A seat on two boards; its origin is the seat's centre.
BodySpec bench() {
  BodySpec spec;
  spec.name = "bench";
  constexpr double kSeat = 0.02;  // half thickness
  spec.parts.resize(3);
  spec.parts[0].shape = collision::Box{Vec3(0.6, 0.15, kSeat)};
  const double leg = 0.5 * (RoomScenario::kBench - 2.0 * kSeat);
  for (std::size_t i = 1; i < 3; ++i) {
    spec.parts[i].shape = collision::Box{Vec3(0.02, 0.13, leg)};
    spec.parts[i].local.position = Vec3(i == 1 ? -0.45 : 0.45, 0.0, -kSeat - leg);
  }
  spec.mass = 8.0;
  spec.pose = upright_at(0.0, -1.2, RoomScenario::kBench - kSeat);
  spec.material = rough();
  return spec;
}

void add_avatar(SceneBuilder& builder, std::size_t user) {
  const double side = user == 0 ? -1.0 : 1.0;
  const auto part = [&](const std::string& name, double radius, const Vec3& place) {
    BodySpec spec;
    spec.name = name;
    spec.parts = one_part(collision::Sphere{radius});
    spec.pose.position = place;
    spec.collides = false;
    spec.owner = user;
    builder.add(std::move(spec));
  };
  const std::string number = std::to_string(user);
  part("head/" + number, 0.12, Vec3(2.0 * side, -1.8, 1.65));
  part("hand/" + number + "/0", 0.05, Vec3(2.0 * side - 0.3 * side, -1.8 + 0.2 * side, 1.1));
  part("hand/" + number + "/1", 0.05, Vec3(2.0 * side - 0.3 * side, -1.8 - 0.2 * side, 1.1));
}

/// Number of blocks 0, 1, .. stacked in order on the box.
double standing(const Scene& scene) {
  double count = 0.0;
  Vec3 below = scene.pose(scene.index_of("toy/box")).position;
  double half = 0.5 * RoomScenario::kBox;
  for (int k = 0; k < 4; ++k) {
    const Vec3& p = scene.pose(scene.index_of("block/" + std::to_string(k))).position;
    const double gap = p.z() - below.z() - half - 0.5 * RoomScenario::kBlock;
    const bool on = std::abs(gap) < 0.01 && (p - below).head<2>().norm() < 0.06;
    if (!on) return count;
    count += 1.0;
    below = p;
    half = 0.5 * RoomScenario::kBlock;
  }
  return count;
}

class RoomReferee final : public Referee {
 public:
  explicit RoomReferee(const Scene& scene)
      : bench_(scene.index_of("bench")), thrown_(scene.index_of("toy/cylinder")) {}
  void watch(const Scene& scene, double /*time*/) override {
    const Vec3 moved = scene.pose(bench_).position - scene.bodies[bench_].start;
    lifted_ = std::max(lifted_, moved.z());
    fastest_ = std::max(fastest_, scene.twist(thrown_).linear.norm());
  }
  Outcome outcome(const Scene& scene) const override {
    const Vec3 bench = scene.pose(bench_).position - scene.bodies[bench_].start;
    const Vec3 thrown = scene.pose(thrown_).position - scene.bodies[thrown_].start;
    const Vec3& box = scene.pose(scene.index_of("toy/box")).position;
    const Vec3& hull = scene.pose(scene.index_of("toy/hull")).position;
    const bool given = box.x() > 0.7 && box.z() > RoomScenario::kTable;
    return {{"box_handed_over", given ? 1.0 : 0.0},
            {"blocks_stacked", standing(scene)},
            {"bench_lifted_m", lifted_},
            {"bench_moved_m", bench.head<2>().norm()},
            {"thrown_m", thrown.head<2>().norm()},
            {"thrown_m_s", fastest_},
            {"hull_on_shelf", hull.z() > RoomScenario::kShelf ? 1.0 : 0.0}};
  }

 private:
  std::size_t bench_, thrown_;
  double lifted_ = 0.0;   ///< m
  double fastest_ = 0.0;  ///< m/s
};

}  // namespace

Scene RoomScenario::build(const SceneOptions& options) const {
  SceneBuilder builder;
  builder.add(bench());
  add(builder, "toy/box", collision::Box{Vec3::Constant(0.5 * kBox)}, 0.5,
      upright_at(-1.0, 0.2, kTable + 0.5 * kBox));
  add(builder, "toy/hull", hull_toy(), 0.4, upright_at(-1.0, 0.5, kTable));
  add(builder, "toy/cylinder", collision::Cylinder{0.04, 0.08}, 0.3,
      upright_at(-1.0, 0.8, kTable + 0.08));
  for (int k = 0; k < 4; ++k) {
    add(builder, "block/" + std::to_string(k), collision::Box{Vec3::Constant(0.5 * kBlock)}, 0.3,
        upright_at(1.3, 0.1 + 0.2 * k, kTable + 0.5 * kBlock));
  }
  add_avatar(builder, 0);
  add_avatar(builder, 1);
  for (const double side : {-1.0, 1.0}) {
    builder.fix(collision::Box{Vec3(0.35, 0.6, 0.03)}, upright_at(1.2 * side, 0.5, kTable - 0.03),
                rough());
  }
  builder.fix(collision::Box{Vec3(0.6, 0.15, 0.02)}, upright_at(0.0, 2.3, kShelf - 0.02), rough());
  builder.ground(rough());
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
    builder.half_space(normal, -2.5, rough());
  }
  return builder.build(options);
}

std::unique_ptr<User> RoomScenario::make_user(std::size_t user, Controls& controls,
                                              const UserOptions& options) const {
  require_user(user);
  auto person = std::make_unique<Person>(user, controls, options);
  room_script(*person);
  return person;
}

std::unique_ptr<Referee> RoomScenario::make_referee(const Scene& scene) const {
  return std::make_unique<RoomReferee>(scene);
}

Achievement RoomScenario::achievement(const Outcome& outcome) const {
  const bool given = value_of(outcome, "box_handed_over") > 0.5;
  const std::string bench = length_words(value_of(outcome, "bench_moved_m"));
  return {(given ? "handed over a box" : "could not hand over a box") +
              (", carried a bench by " + bench + " and threw a toy by ") +
              length_words(value_of(outcome, "thrown_m")),
          "box handed over", given ? "yes" : "no", given};
}

}  // namespace tandem::demos
