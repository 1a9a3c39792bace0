// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sharing. Two worlds, two peers, and a network in virtual time with 50 ms latency. Their copies of
// one cube start 40 cm apart and become one while the first peer's user drags it.
#include <cstdint>
#include <cstdio>

#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/solver.h"

using namespace tandem;

/// One participant, in practice a program of its own.
struct Site {
  Site(consensus::Transport& transport, const pbd::Vec3& position)
      : peer(world, transport),
        body(world.add_body({.pose = {.position = position}, .linear_damping = 1.0})) {
    peer.share({.id = consensus::SharedId::from_name("cube"), .body = body});
  }
  /// Receives, then steps.
  void step(consensus::SessionTime now, consensus::SessionTime length) {
    peer.before_step(now);
    solver.step(world, 1e-9 * static_cast<double>(length));
  }
  pbd::Vec3 position() const { return world.pose(body).position; }

  pbd::World world{{.gravity = pbd::Vec3::Zero()}};
  pbd::Solver solver;
  consensus::Peer peer;
  pbd::BodyId body;
};

int main() {
  constexpr consensus::SessionTime kStep = 16'666'667;  // ns
  consensus::SessionTime now = 1'000'000'000;
  consensus::VirtualNetwork network({.latency = 0.05, .jitter = 0.005}, 1, now);
  // Both join before either sends.
  consensus::Transport& first = network.transport(1);
  consensus::Transport& second = network.transport(2);
  Site one(first, pbd::Vec3(0.0, 0.0, 0.0));
  Site two(second, pbd::Vec3(0.0, 0.4, 0.0));

  const pbd::Vec3 hand(1.0, 0.2, 0.5);  // m
  const consensus::GrabId grab =
      one.peer.grab({.body = consensus::SharedId::from_name("cube"), .anchor_w = hand});
  for (int i = 0; i <= 600; ++i) {
    if (i % 120 == 0) {
      const pbd::Vec3 x = one.position();
      std::printf("%4.1f s: at peer 1 (%.3f, %.3f, %.3f), the other copy %.4f m away\n", i / 60.0,
                  x.x(), x.y(), x.z(), (two.position() - x).norm());
    }
    one.peer.move(grab, hand, now);
    one.step(now, kStep);
    two.step(now, kStep);
    now += kStep;
    network.advance_to(now);
    one.peer.after_step(now);  // sends the body's new state
    two.peer.after_step(now);
  }

  // Both simulate the first user's spring, so both end at its hand.
  const double apart = (one.position() - two.position()).norm();
  const double missed = (two.position() - hand).norm();
  std::printf("apart by %.2g m, at the second peer %.2g m from the first one's hand\n", apart,
              missed);
  return apart < 1e-3 && missed < 1e-2 ? 0 : 1;
}
