// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/session.h"

#include <cstdio>

#include "tandem/net/tcp.h"

// A world without shapes, alone in a session on loopback for a tenth of a second.
int main() {
  using namespace tandem;
  pbd::World world;
  pbd::Solver solver;
  const pbd::BodyId ball = world.add_body({});
  Session session({world, solver},
                  net::TcpOptions{.self = 1, .listen_port = 0, .listen_address = "127.0.0.1"});
  session.share("ball", ball);
  int steps = 0;
  session.run([&](SessionTime) {
    if (++steps > 6) session.stop();
  });
  std::printf("session: %d steps in %.3f s\n", steps - 1, world.time());
  return steps == 7 && world.pose(ball).position.z() < 0.0 ? 0 : 1;
}
