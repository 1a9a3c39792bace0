// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Cost of the live view: bytes on the socket and CPU time of the server's thread, for balls that
// all move in every frame and one page.
//
//   view_cost [BALLS [PANES [SECONDS]]]    defaults: 1000 balls, 2 panes, 10 s
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "support/web_client.h"
#include "view/server.h"

namespace {

using namespace tandem;
using namespace tandem::demos::view;
using Clock = std::chrono::steady_clock;

constexpr double kFramesPerSecond = 60.0;

/// Every ball circles fast enough to move in each frame.
void move(Frame& frame, double time) {
  frame.time = time;
  for (std::size_t p = 0; p < frame.panes.size(); ++p) {
    std::vector<pbd::Pose>& poses = frame.panes[p].poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double angle = time + 0.37 * static_cast<double>(i) + 1e-3 * static_cast<double>(p);
      poses[i].position =
          pbd::Vec3(std::cos(angle), std::sin(angle), 0.01 * static_cast<double>(i));
    }
  }
}

void run(std::size_t balls, std::size_t panes, double seconds) {
  Layout layout;
  layout.position_unit = 20.0 / 0x100000;
  layout.panes.resize(panes);
  layout.bodies.resize(balls);
  for (Layout::Body& body : layout.bodies) body.turns = false;
  Server server({}, layout, {});
  server.set_hello("{}");

  std::size_t received = 0, frames = 0;
  std::thread page([&] {
    testing::WebClient client("127.0.0.1", server.port());
    client.open('/' + server.token() + "/socket", "127.0.0.1:" + std::to_string(server.port()));
    while (const auto message = client.hear()) {
      received += message->bytes.size() + 4;  // and the header of a message of that size
      frames += message->binary ? 1 : 0;
      if (!message->binary && message->bytes == "end") break;
    }
  });
  Frame frame;
  const Clock::time_point start = Clock::now();
  const auto count = static_cast<int>(seconds * kFramesPerSecond);
  const double cpu_before = server.counters().cpu_s;
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(
                                              std::chrono::duration<double>(i / kFramesPerSecond)));
    frame.panes.resize(panes);
    for (PaneFrame& pane : frame.panes) pane.poses.resize(balls);
    move(frame, i / kFramesPerSecond);
    server.show(frame);
  }
  server.tell("end");
  page.join();
  const std::chrono::duration<double> wall = Clock::now() - start;
  const Server::Counters counters = server.counters();
  std::printf(
      "%zu balls, %zu panes: %zu of %d frames, %llu whole; %.2f Mbit/s at %.1f frames/s, "
      "%.2f %% of one core\n",
      balls, panes, frames, count, static_cast<unsigned long long>(counters.keys),
      8e-6 * static_cast<double>(received) / wall.count(),
      static_cast<double>(frames) / wall.count(),
      100.0 * (counters.cpu_s - cpu_before) / wall.count());
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int place, double fallback) {
    return argc > place ? std::atof(argv[place]) : fallback;
  };
  run(static_cast<std::size_t>(number(1, 1000.0)), static_cast<std::size_t>(number(2, 2.0)),
      number(3, 10.0));
}
