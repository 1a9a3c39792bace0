// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Difficult piles after samples of Box3D: with gaps or overlap at the start, without side gaps, or
// with heavy boxes above light ones.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include "measure/penetration.h"
#include "numerics/case.h"
#include "tandem/pbd/math.h"

namespace tandem::bench {
namespace {

constexpr double kFriction = 0.6;
/// s: overlaps count from here; some scenes start with them.
constexpr double kSettled = 0.5;

/// Ground, and boxes to add in some order.
struct Pile {
  Scene scene;
  std::vector<SceneBody> boxes;

  Pile() {
    scene.add_static(BoxShape{Vec3(50.0, 50.0, 1.0)}, {.position = Vec3(0.0, 0.0, -1.0)});
    scene.bodies.back().friction = kFriction;
  }
  void add(const Vec3& half, double density, const Vec3& place, const Vec3& turn = Vec3::Zero()) {
    scene.add(BoxShape{half}, 8.0 * density * half.prod(),
              {.position = place, .orientation = pbd::exp_map(turn)});
    scene.bodies.back().friction = kFriction;
    boxes.push_back(scene.bodies.back());
    scene.bodies.pop_back();
  }
};

struct Stand {
  double overlap = 0.0;  ///< m, maximum once settled
  double drift = 0.0;    ///< m, maximum sideways
};

/// @param order  0 as listed, otherwise the seed of a shuffle
Stand stand(const Sheet& sheet, const Pile& pile, int order) {
  Scene scene = pile.scene;
  std::vector<std::size_t> turn(pile.boxes.size());
  std::iota(turn.begin(), turn.end(), std::size_t{0});
  std::mt19937 random(static_cast<std::uint32_t>(order));
  for (std::size_t i = turn.size() - 1; order > 0 && i > 0; --i) {
    std::swap(turn[i], turn[random() % (i + 1)]);
  }
  for (const std::size_t i : turn) scene.bodies.push_back(pile.boxes[i]);
  const auto engine = sheet.make(scene);
  PenetrationProbe probe(scene);
  Stand result;
  for (int frame = 0; frame < scene.frames(); ++frame) {
    engine->step(scene.dt);
    if ((frame + 1) * scene.dt <= kSettled) continue;
    const double deepest = probe.measure(*engine).max;
    result.overlap = std::isnan(deepest) ? HUGE_VAL : std::max(result.overlap, deepest);
  }
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    const Vec3 moved =
        engine->state(static_cast<int>(i)).pose.position - scene.bodies[i].pose.position;
    result.drift = std::max(result.drift, std::hypot(moved.x(), moved.y()));
  }
  return result;
}

void check(Sheet& sheet, const Pile& pile, double thickness, double drift, int orders) {
  Stand worst;
  for (int order = 0; order < orders; ++order) {
    const Stand one = stand(sheet, pile, order);
    worst.overlap = std::max(worst.overlap, one.overlap);
    worst.drift = std::max(worst.drift, one.drift);
  }
  sheet.at_most("overlap", 1e3 * worst.overlap, 50.0 * thickness, "mm", "5 % of the thickness");
  sheet.at_most("drift", 1e3 * worst.drift, 1e3 * drift, "mm", "stands, as in Box3D");
}

/// Two bars across two bars, 30 layers, each 1 cm above the last; the lowest begin in the ground.
void bars(Sheet& sheet) {
  constexpr double kLong = 1.0;
  constexpr double kThin = 0.1;
  Pile pile;
  for (int i = 0; i < 30; ++i) {
    const bool along_x = i % 2 == 1;
    for (const double side : {1.0, -1.0}) {
      const double off = side * (kLong - 2.0 * kThin);
      pile.add(Vec3(kLong, kThin, kThin), 1000.0,
               Vec3(along_x ? 0.0 : off, along_x ? off : 0.0, (2.1 * i + 0.5) * kThin),
               Vec3(0.0, 0.0, along_x ? 0.0 : std::numbers::pi / 2.0));
    }
  }
  check(sheet, pile, 2.0 * kThin, 0.05, 10);
}

/// Boxes of half extent e in rows, side by side.
Pile close_pyramid(int rows, double e) {
  Pile pile;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < rows - i; ++j) {
      pile.add(Vec3::Constant(e), 1000.0,
               Vec3((i + 1 + 2 * j - rows) * e, 0.0, (2.0 * i + 1.0) * e));
    }
  }
  return pile;
}

/// Three pyramids of 8 kg boxes; on each a box of 100, 200 or 300 times that mass falls from 2 m.
void heavy_on_light(Sheet& sheet) {
  Pile pile;
  for (int k = 0; k < 3; ++k) {
    for (int count = 10; count > 0; --count) {
      for (int i = 0; i < count; ++i) {
        const double height = 1.0 + 2.0 * (10 - count) + (count == 1 ? 2.0 : 0.0);
        pile.add(Vec3::Ones(), count == 1 ? 100.0 * (k + 1) : 1.0,
                 Vec3(2.0 * (i - 0.5 * count) - 20.0 + 22.0 * k, 0.0, height));
      }
    }
  }
  check(sheet, pile, 2.0, 0.14, 1);
}

/// Five storeys of leaning cards, 1 cm thick, with others across them; all overlap by 3 mm.
void cards(Sheet& sheet) {
  const Vec3 half(0.005, 0.1, 0.2);
  const double lean = 25.0 * std::numbers::pi / 180.0;
  Pile pile;
  double from = 0.0;
  double z = half.z() - 0.02;
  for (int storey = 5; storey > 0; --storey) {
    double x = from;
    for (int i = 0; i < storey; ++i) {
      if (i + 1 < storey) {
        pile.add(half, 1000.0, Vec3(x + 0.25, 0.0, z + half.z() - 0.015),
                 Vec3(0.0, std::numbers::pi / 2.0, 0.0));
      }
      pile.add(half, 1000.0, Vec3(x, 0.0, z), Vec3(0.0, lean, 0.0));
      pile.add(half, 1000.0, Vec3(x + 0.175, 0.0, z), Vec3(0.0, -lean, 0.0));
      x += 0.35;
    }
    z += 2.0 * half.z() - 0.03;
    from += 0.175;
  }
  check(sheet, pile, 2.0 * half.x(), 0.1, 1);
}

}  // namespace

std::vector<Case> pile_cases() {
  const std::string family = "extreme";
  return {
      {family, "tower of 60 bars, dropped by 1 cm each", bars},
      {family, "pyramid of 50 rows without side gaps",
       [](Sheet& s) { check(s, close_pyramid(50, 0.5), 1.0, 0.02, 1); }},
      {family, "pyramid of 30 rows of 5 cm without side gaps",
       [](Sheet& s) { check(s, close_pyramid(30, 0.025), 0.05, 0.005, 2); }},
      {family, "heavy boxes dropped on light ones", heavy_on_light},
      {family, "house of cards of 1 cm", cards},
  };
}

}  // namespace tandem::bench
