// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "scene.h"

namespace tandem::extreme_bench {
namespace {

Scene tug(std::string name, Conditions conditions) {
  Scene scene = tug_of_war();
  scene.name = std::move(name);
  scene.group = "conditions";
  scene.conditions = std::move(conditions);
  return scene;
}

std::string text(Topology topology) {
  constexpr std::array names = {"mesh", "star", "ring"};
  return names[static_cast<std::size_t>(topology)];
}

/// Bodies whose copies disagree; copies are in a row along x, by peer.
enum class Shared { Free, Box, Stack };

Scene spread(Shared shared, int peers, Topology topology, double apart) {
  constexpr std::array kinds = {"free body", "box on a floor", "stack of three"};
  const std::string far = apart < 0.5 ? "10 cm" : "1 m";
  Scene scene{.name = std::string(kinds[static_cast<std::size_t>(shared)]) + ", " + far + ", " +
                      text(topology),
              .group = "topology",
              .seconds = 20.0,
              .peers = peers,
              .topology = topology};
  scene.build = [=](int peer) {
    const double x = apart * peer / (peers - 1);
    CopyBuilder b;
    if (shared == Shared::Free) {
      b.world().set_gravity(Vec3::Zero());
      box_at(b, {x, 0.0, 0.0});
    } else {
      floor(b);
      const int boxes = shared == Shared::Box ? 1 : 3;
      for (int i = 0; i < boxes; ++i) box_at(b, {x, 0.0, kHalf * (2 * i + 1)});
    }
    return b.done();
  };
  scene.stands = shared == Shared::Stack;
  return scene;
}

}  // namespace

std::vector<Scene> condition_scenes() {
  std::vector<Scene> scenes;
  scenes.push_back(tug("owners on both sides", {.owners = true}));
  scenes.push_back(tug("both announce share 1", {.share = 1.0}));
  scenes.push_back(tug("updates at 5 and 90 Hz", {.update_hz = {5.0, 90.0}}));
  Scene rates = tug("steps at 30 and 240 Hz", {.pace = {{.hz = 30.0}, {.hz = 240.0}}});
  rates.sample_hz = 30.0;
  scenes.push_back(std::move(rates));
  Scene loss = tug("loss 50 %", {.loss = 0.5});
  loss.seconds = 34.0;  // four periods in each quarter
  scenes.push_back(std::move(loss));
  Scene frozen =
      tug("peer frozen for 2 s", {.pace = {{}, {.frozen_from = 1.5, .frozen_until = 3.5}}});
  frozen.differs = 0.6;  // the distance that one hand alone pulls
  scenes.push_back(std::move(frozen));
  scenes.push_back(tug("clocks 20 ms apart", {.pace = {{}, {.ahead = 0.02}}}));
  Scene fall{.name = "frozen while it falls", .group = "conditions"};
  fall.build = [](int) {
    CopyBuilder b;
    floor(b);
    box_at(b, up(4.0));
    return b.done();
  };
  fall.conditions.pace = {{}, {.frozen_from = 0.5, .frozen_until = 2.5}};
  fall.differs = 4.0;
  scenes.push_back(std::move(fall));
  return scenes;
}

std::vector<Scene> topology_scenes() {
  std::vector<Scene> scenes;
  for (const Shared shared : {Shared::Free, Shared::Box, Shared::Stack}) {
    for (const double apart : {0.1, 1.0}) {
      for (const int peers : {2, 4, 8, 16}) {
        scenes.push_back(spread(shared, peers, Topology::Mesh, apart));
        if (peers == 2) continue;  // all topologies are the same
        scenes.push_back(spread(shared, peers, Topology::Star, apart));
        scenes.push_back(spread(shared, peers, Topology::Ring, apart));
      }
    }
  }
  return scenes;
}

}  // namespace tandem::extreme_bench
