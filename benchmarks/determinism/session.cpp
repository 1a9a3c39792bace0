// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <memory>
#include <string>
#include <vector>

#include "determinism/case.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/portable.h"

namespace tandem::determinism {
namespace {

/// One participant with a plate and cubes on it, all of them shared.
struct Site {
  Site(consensus::Transport& transport, const Run& run)
      : scene(scene_options(run)), peer(scene.world(), transport) {
    scene.add(HalfSpace{}, {.type = BodyType::Static});
    share("plate", scene.add(Box{0.6, 0.6, 0.03},
                             {.density = 200.0, .pose = {.position = Vec3(0.0, 0.0, 0.03)}}));
    for (int i = 0; i < 9; ++i) {
      const Vec3 place(0.3 * (i % 3 - 1), 0.3 * (i / 3 - 1), 0.16);
      share("cube" + std::to_string(i),
            scene.add(Box{0.1, 0.1, 0.1}, {.density = 100.0, .pose = {.position = place}}));
    }
  }
  void share(const std::string& name, BodyId body) {
    peer.share({.id = consensus::SharedId::from_name(name), .body = body});
  }

  Scene scene;
  consensus::Peer peer;
};

}  // namespace

std::uint64_t run_session(const Run& run) {
  constexpr consensus::SessionTime kFrame = 16'666'667;  // ns
  constexpr int kSites = 3;
  consensus::SessionTime now = 1'000'000'000;
  consensus::VirtualNetwork network({.latency = 0.06, .jitter = 0.02, .loss = 0.05}, 7, now);
  std::vector<consensus::Transport*> transports;
  for (consensus::PeerId id = 1; id <= kSites; ++id) transports.push_back(&network.transport(id));
  std::vector<std::unique_ptr<Site>> sites;
  for (consensus::Transport* transport : transports)
    sites.push_back(std::make_unique<Site>(*transport, run));

  // The first two lift the plate at its edges and sway it; the third one pulls at a cube.
  const auto hand = [](int site, int step) {
    const double t = step / 60.0;
    const double lift = t < 2.0 ? 0.25 * t : 0.5;
    const Vec3 sway(0.3 * pbd::portable::sin_cos(1.1 * t).sin,
                    0.2 * pbd::portable::sin_cos(0.7 * t).sin, 0.05 + lift);
    return Vec3(sway + Vec3(site == 0 ? -0.6 : 0.6, 0.0, 0.0));
  };
  std::vector<consensus::GrabId> grabs;
  for (int k = 0; k < kSites; ++k) {
    grabs.push_back(sites[static_cast<std::size_t>(k)]->peer.grab(
        {.body = consensus::SharedId::from_name(k < 2 ? "plate" : "cube4"),
         .attachment_l = k < 2 ? Vec3(k == 0 ? -0.6 : 0.6, 0.0, 0.0) : Vec3(Vec3::Zero()),
         .anchor_w = hand(k, 0)}));
  }
  for (int step = 0; step < run.steps; ++step) {
    for (std::size_t k = 0; k < sites.size(); ++k) {
      Site& site = *sites[k];
      site.peer.move(grabs[k], hand(static_cast<int>(k), step), now);
      site.peer.before_step(now);
      site.scene.step(1e-9 * static_cast<double>(kFrame));
    }
    now += kFrame;
    network.advance_to(now);
    for (auto& site : sites) site->peer.after_step(now);
  }
  std::uint64_t hash = 0;
  for (const auto& site : sites) hash = 31 * hash + site->scene.world().hash();
  return hash;
}

}  // namespace tandem::determinism
