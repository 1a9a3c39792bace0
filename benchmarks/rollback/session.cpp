// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "rollback/session.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <tuple>

#include "demos/scenes/random.h"
#include "runner/virtual_session.h"
#include "tandem/consensus/virtual_network.h"

namespace tandem::rollback_bench {

namespace {

std::int64_t frames_of(const demos::DemoOptions& demo) {
  return std::llround(demo.seconds * kFrameHz);
}

/// Hashes of one world with all inputs, by frame.
std::vector<std::uint64_t> true_hashes(const demos::Scenario& scenario,
                                       const demos::DemoOptions& demo,
                                       std::deque<RollbackPeer>& peers) {
  consensus::VirtualNetwork nobody;
  RollbackPeer all(scenario, demo, {.max_frames_per_tick = 1}, 0, nobody.transport(1));
  const std::int64_t frames = frames_of(demo);
  for (std::size_t i = 0; i < peers.size(); ++i) {
    std::vector<Inputs> inputs = peers[i].own();
    inputs.resize(std::max(inputs.size(), static_cast<std::size_t>(frames + 1)));
    all.set_inputs(i, std::move(inputs));
  }
  for (std::int64_t frame = 0; frame < frames; ++frame) all.tick(frame);
  return all.hashes();
}

void compare(const std::vector<std::uint64_t>& truth, const std::vector<std::uint64_t>& hashes,
             Run& run) {
  for (std::size_t frame = 0; frame < std::min(truth.size(), hashes.size()); ++frame) {
    if (hashes[frame] == 0 || truth[frame] == 0) continue;
    ++run.confirmed;
    if (hashes[frame] == truth[frame]) continue;
    const auto at = static_cast<std::int64_t>(frame);
    if (run.first_desync < 0 || at < run.first_desync) run.first_desync = at;
    return;
  }
}

}  // namespace

Run run_rollback(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                 const RollbackOptions& options) {
  const auto count = static_cast<std::size_t>(demo.peers);
  consensus::VirtualNetwork network(demo.link_options(), demos::derived_seed(demo.seed, 5000),
                                    demos::kVirtualStart);
  for (std::size_t i = 0; i < count; ++i) network.transport(i + 1);
  demo.set_links(network);
  std::deque<RollbackPeer> peers;
  for (std::size_t i = 0; i < count; ++i) {
    peers.emplace_back(scenario, demo, options, i, network.transport(i + 1));
  }
  for (std::int64_t frame = 0; frame < frames_of(demo); ++frame) {
    network.advance_to(frame_time(frame));
    for (RollbackPeer& peer : peers) peer.tick(frame);
  }
  Run run;
  const std::vector<std::uint64_t> truth = true_hashes(scenario, demo, peers);
  double steps = 0.0;
  for (RollbackPeer& peer : peers) {
    compare(truth, peer.hashes(), run);
    const RollbackStats& stats = peer.stats();
    run.frame_ms.insert(run.frame_ms.end(), stats.frame_ms.begin(), stats.frame_ms.end());
    steps += static_cast<double>(stats.steps);
    run.stalled += stats.stalled;
    run.snapshot_bytes = std::max(run.snapshot_bytes, stats.snapshot_bytes);
    run.peers.push_back(peer.record());
  }
  run.steps_per_frame = steps / static_cast<double>(run.frame_ms.size());
  return run;
}

Run run_coupling(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                 std::optional<int> other_substeps, std::int64_t join) {
  demos::DemoOptions without_users = demo;
  without_users.no_script = true;
  without_users.equal_starts = true;
  demos::VirtualSession session(scenario, without_users, nullptr);
  std::vector<demos::Actor>& actors = session.actors();
  if (other_substeps) {
    demos::DemoOptions other = without_users;
    other.solver.substeps = *other_substeps;
    actors[1] = demos::Actor(scenario, other, 1, session.network().transport(2));
  }
  const std::size_t last = actors.size() - 1;
  const auto add_users = [&](bool late) {
    for (std::size_t user = 0; user < scenario.user_count(); ++user) {
      const std::size_t seat = demos::seat_of(demo, user);
      if (late != (join > 0 && seat == last)) continue;
      actors[seat].participant().add_user(user,
                                          demos::user_options(demo, user, demos::kVirtualStart));
    }
  };
  Run run;
  std::vector<double> cpu(actors.size());
  const auto run_to = [&](consensus::SessionTime end) {
    while (true) {
      const std::size_t next = demos::next_actor(actors);
      const bool ends = std::get<1>(actors[next].next()) == 0;
      if (!session.act(end)) break;
      if (!ends) continue;  // a frame is complete at its end
      const double sum = actors[next].participant().cpu_s();
      run.frame_ms.push_back(1e3 * (sum - cpu[next]));
      cpu[next] = sum;
    }
    session.network().advance_to(end);
  };
  add_users(false);
  if (join > 0) {
    actors.back().sleep_until(frame_time(join));
    const auto link = [&](auto change) {
      for (consensus::PeerId id = 1; id <= last; ++id) {
        change(id, last + 1);
        change(last + 1, id);
      }
    };
    consensus::VirtualNetwork& network = session.network();
    link([&](consensus::PeerId from, consensus::PeerId to) { network.cut(from, to); });
    // The request arrives one latency later.
    run_to(frame_time(join) + std::llround(1e9 * demo.link_options().latency));
    link([&](consensus::PeerId from, consensus::PeerId to) { network.heal(from, to); });
    run_to(frame_time(join + kJoinLead));
    add_users(true);
  }
  run_to(frame_time(frames_of(demo)));
  for (demos::Actor& actor : actors) run.peers.push_back(actor.participant().record());
  return run;
}

}  // namespace tandem::rollback_bench
