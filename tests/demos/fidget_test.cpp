// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/fidget.h"

#include "peer/divergence_gauge.h"
#include "scenes/cubes.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos::fidget_test {
namespace {

constexpr consensus::SessionTime kStep = 16'666'667;

/// One peer of a session with somebody who cannot leave things alone.
struct Seat {
  Seat(consensus::VirtualNetwork& network, consensus::PeerId id)
      : scene(CubesScenario().build({.order_seed = id, .noise_seed = id})),
        peer(*scene.world, network.transport(id)),
        controls(0, scene, peer, kStep),
        fidget(controls, id) {
    for (const SceneBody& body : scene.bodies) peer.share({.id = body.id, .body = body.body});
    peer.set_observer(&gauge);
  }
  void step(consensus::SessionTime now) {
    controls.begin(now, 1e-9 * static_cast<double>(kStep));
    fidget.update(now);
    peer.before_step(now);
    const pbd::StepReport& report = solver.step(*scene.world, 1e-9 * static_cast<double>(kStep));
    good = good && report.status == pbd::StepStatus::Ok;
  }

  Scene scene;
  DivergenceGauge gauge;
  consensus::Peer peer;
  Controls controls;
  Fidget fidget;
  pbd::Solver solver;
  bool good = true;
};

TEST_CASE("fidget: takes one thing after the other, and nothing gets lost", "[demos]") {
  consensus::VirtualNetwork network({.latency = 0.03, .loss = 0.05}, 1, kStep);
  network.transport(1);
  network.transport(2);
  Seat a(network, 1), b(network, 2);
  consensus::SessionTime now = kStep;
  for (int i = 0; i < 60 * 60; ++i) {
    network.advance_to(now);
    a.step(now);
    b.step(now);
    now += kStep;
    network.advance_to(now);
    a.peer.after_step(now);
    b.peer.after_step(now);
  }
  for (const Seat* seat : {&a, &b}) {
    CHECK(seat->good);
    CHECK(seat->fidget.done() > 10);
    for (const SceneBody& body : seat->scene.bodies) {
      CAPTURE(body.name);
      CHECK((seat->scene.pose(body).position - body.start).norm() < 2.5);
      CHECK(seat->scene.pose(body).position.z() > 0.0);
    }
    CHECK(seat->gauge.all().count() > 10000);
    CHECK(seat->gauge.all().quantile(0.5) < 0.02);
    CHECK(seat->gauge.all().quantile(0.99) > 1e-4);  // hands are not foreseen
  }
  CHECK(a.gauge.of(2) != nullptr);
  CHECK(a.gauge.of(3) == nullptr);
}

}  // namespace
}  // namespace tandem::demos::fidget_test
