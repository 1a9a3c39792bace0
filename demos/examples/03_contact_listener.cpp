// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Shapes, and a contact listener: begin, end and speed of each impact. A ball with restitution 0.5
// falls on the ground; each impact has half the speed of the last.
#include <cmath>
#include <cstdio>
#include <vector>

#include "tandem/scene.h"

using namespace tandem;

/// A game would play sounds here.
class Listener {
 public:
  void on_begin(const collision::ContactPair& /*pair*/) { ++begun; }
  void on_end(const collision::ContactPair& /*pair*/) { ++ended; }
  void on_hit(const collision::ContactHit& hit, double time) {
    std::printf("%.3f s: hit at %.3f m/s, %.3f N s\n", time, hit.speed, hit.impulse);
    speeds.push_back(hit.speed);
  }

  int begun = 0;
  int ended = 0;
  std::vector<double> speeds;  // m/s
};

int main() {
  constexpr double kHeight = 2.0;       // m, from the ball's lowest point
  constexpr double kRadius = 0.1;       // m
  constexpr double kRestitution = 0.5;  // a pair has the larger value

  Scene scene({.events = {.hit_speed = 0.5}});
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId ball =
      scene.add(Sphere{kRadius}, {.density = 500.0,
                                  .pose = {.position = {0.0, 0.0, kHeight + kRadius}},
                                  .material = {.restitution = kRestitution}});

  Listener listener;
  while (scene.world().time() < 4.0) {
    if (scene.step(1.0 / 240.0).status != pbd::StepStatus::Ok) return 1;
    const collision::ContactEvents& events = scene.events();
    for (const collision::ContactPair& pair : events.begun()) listener.on_begin(pair);
    for (const collision::ContactPair& pair : events.ended()) listener.on_end(pair);
    for (const auto& hit : events.hits()) listener.on_hit(hit, scene.world().time());
  }

  // sqrt(2 g h) at first, then half of the one before; finally the ball rests.
  const std::vector<double>& speeds = listener.speeds;
  bool holds = speeds.size() >= 3 && listener.begun == listener.ended + 1;
  double expected = std::sqrt(2.0 * 9.81 * kHeight);
  for (std::size_t i = 0; holds && i < 3; ++i) {
    holds = std::abs(speeds[i] / expected - 1.0) < 0.02;
    expected *= kRestitution;
  }
  std::printf("%d times begun, %d times ended, at rest at %.4f m\n", listener.begun, listener.ended,
              scene.pose(ball).position.z());
  return holds && std::abs(scene.pose(ball).position.z() - kRadius) < 1e-3 ? 0 : 1;
}
