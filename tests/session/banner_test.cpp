// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Cloth of different resolutions is one thing: two people hold a banner by its poles, one of them
// with 30 x 20 particles, the other with 60 x 40 (docs/parts.md).
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/catch.h"
#include "tandem/cloth.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"

namespace banner_test {

using namespace tandem;
using consensus::SessionTime;
using consensus::SharedId;

constexpr double kWidth = 1.8, kHeight = 1.0;  // m
constexpr SessionTime kStep = 16'666'667;      // ns

/// One person's world, and what they do to it.
struct Site {
  Site(consensus::Transport& transport, int columns, int rows, int side_of_user)
      : cloth(scene, {.pose = {Vec3(-0.5 * kWidth, 0.0, 1.0),
                               Quat(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()))},
                      .width = kWidth,
                      .height = kHeight,
                      .columns = columns,
                      .rows = rows,
                      .radius = 0.005,
                      .damping = 1.0}),
        peer(scene.world(), transport),
        side(side_of_user) {
    for (int k = 0; k < 2; ++k) {
      poles[k] = scene.add(Cylinder{0.02, 0.6},
                           {.mass = 1.5,
                            .pose = {.position = pole_at(k, 0.0)},
                            .filter = {.mask = 0},
                            .gravity_scale = 0.0,  // the other one holds it before that is known
                            .linear_damping = 1.0,
                            .angular_damping = 2.0});
      for (int row = 0; row < rows; ++row) cloth.attach(k == 0 ? 0 : columns - 1, row, poles[k]);
      share("pole " + std::to_string(k), poles[k], true);
    }
    for (int i = 1; i < 7; ++i) {
      for (int k = 0; k < 5; ++k) {
        const BodyId handle = cloth.add_handle(i / 7.0, k / 4.0, 0.25, 0.9);
        share("cloth " + std::to_string(i) + " " + std::to_string(k), handle, false);
      }
    }
    for (int k = 0; k < 2; ++k) {
      grabs[k] = peer.grab({.body = SharedId::from_name("pole " + std::to_string(side)),
                            .attachment_l = hand_on_pole(k),
                            .anchor_w = pole_at(side, 0.0) + hand_on_pole(k),
                            .stiffness = 600.0,
                            .damping = 40.0,
                            .max_force = 200.0});
    }
  }
  void share(const std::string& name, BodyId body, bool turns) {
    peer.share({.id = SharedId::from_name(name), .body = body, .orientation = turns});
  }
  static Vec3 hand_on_pole(int k) { return Vec3(0.0, 0.0, k == 0 ? -0.4 : 0.4); }
  /// The person's target for the pole: closer together, forth and back, up and down.
  static Vec3 pole_at(int k, double t) {
    const double out = k == 0 ? -1.0 : 1.0;
    const double ease = std::min(1.0, t / 2.0);
    return {out * (0.5 * kWidth - 0.1 * ease - 0.06 * ease * std::sin(1.3 * t)),
            ease * 0.35 * std::sin(1.7 * t + 0.8 * k), 1.5 + ease * 0.15 * std::sin(1.1 * t + k)};
  }
  void step(double t, SessionTime now) {
    for (int k = 0; k < 2; ++k) peer.move(grabs[k], pole_at(side, t) + hand_on_pole(k), now);
    peer.before_step(now);
    REQUIRE(scene.step(1e-9 * static_cast<double>(kStep)).status == pbd::StepStatus::Ok);
  }

  Scene scene;
  Cloth cloth;
  consensus::Peer peer;
  int side;
  BodyId poles[2];
  consensus::GrabId grabs[2];
};

struct Apart {
  double attached = 0.0, cloth = 0.0;  ///< m, 95 of 100 times less
};

double percentile(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 95 / 100];
}

Apart carry(double seconds) {
  SessionTime now = 1'000'000'000;
  consensus::VirtualNetwork network(consensus::network_profile(3), 1, now);
  consensus::Transport& first = network.transport(1);
  consensus::Transport& second = network.transport(2);
  Site coarse(first, 30, 20, 0);
  Site fine(second, 60, 40, 1);
  std::vector<double> attached, cloth;
  for (double t = 0.0; t < seconds; t += 1e-9 * static_cast<double>(kStep)) {
    coarse.step(t, now);
    fine.step(t, now);
    now += kStep;
    network.advance_to(now);
    coarse.peer.after_step(now);
    fine.peer.after_step(now);
    if (t < 1.0) continue;
    for (int i = 0; i <= 18; ++i) {
      for (int k = 0; k <= 10; ++k) {
        const double u = i / 18.0, v = k / 10.0;
        const double apart = (coarse.cloth.point(u, v) - fine.cloth.point(u, v)).norm();
        (i == 0 || i == 18 ? attached : cloth).push_back(apart);
      }
    }
  }
  return {percentile(attached), percentile(cloth)};
}

TEST_CASE("banner: two people hold one, at 30 x 20 and at 60 x 40 particles",
          "[session][consensus]") {
  const Apart apart = carry(3.0);
  CHECK(apart.attached <= 0.003);
  CHECK(apart.cloth <= 0.055);
}

}  // namespace banner_test
