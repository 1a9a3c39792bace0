// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <tuple>
#include <vector>

#include "copies/copy.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/solver.h"

namespace tandem::peers_bench {

using consensus::SessionTime;

inline constexpr SessionTime kStart = 1'000'000'000;  ///< ns

inline SessionTime ns(double seconds) { return std::llround(1e9 * seconds); }
consensus::SharedId shared_id(std::size_t index);

/// s: latency at which states are `frames` steps of 1/60 s old on use, slightly less against
/// rounding.
constexpr double latency_of(int frames) { return frames > 0 ? frames / 60.0 - 1e-6 : 0.0; }

/// A peer's rate and clock.
struct Pace {
  double hz = 60.0;           ///< steps per second
  double ahead = 0.0;         ///< s, lead of its session clock
  double frozen_from = 0.0;   ///< s since the start; beginning of a pause without steps
  double frozen_until = 0.0;  ///< s, end of the pause
};

/// One peer with its copy of the scene, all bodies shared.
class Site {
 public:
  /// @param owns  this peer claims all bodies
  Site(Copy made, consensus::Transport& transport, const consensus::PeerOptions& options,
       const Pace& pace = {}, bool owns = false,
       const pbd::SolverOptions& steps = {.measure_stages = false});

  consensus::PeerId id;
  Copy copy;
  pbd::Solver solver;
  consensus::Peer peer;
  double cpu = 0.0;  ///< s, of all steps, including the exchange
  /// Acts before each step. @param time  s since the start, wall time
  std::function<void(Site&, double time)> user;
  /// Before and after the solver's step; see consensus::Peer.
  std::function<void(Site&)> begun;
  std::function<void(Site&, const pbd::StepReport&, double dt)> stepped;

  /// The peer's own clock at this wall time.
  SessionTime clock(double time) const { return kStart + ns(time + pace_.ahead); }

  // For Session: the next event, ends of steps (0) before beginnings (1).
  std::tuple<SessionTime, int> next() const {
    return inside_ ? std::tuple{at(steps_ + 1), 0} : std::tuple{at(steps_), 1};
  }
  void act();

 private:
  SessionTime at(std::int64_t step) const {
    return kStart + std::llround(1e9 * static_cast<double>(step) / pace_.hz);
  }

  Pace pace_;
  std::int64_t steps_ = 0;
  bool inside_ = false;  ///< the step is computed and waits for its end
};

/// Peers of one process in virtual time.
class Session {
 public:
  explicit Session(const consensus::LinkOptions& link, std::uint64_t seed = 1)
      : network(link, seed, kStart) {}

  consensus::VirtualNetwork network;
  std::vector<std::unique_ptr<Site>> sites;

  /// Steps that end at this time (s since the start) run; none begins then.
  void run_until(double time);
};

}  // namespace tandem::peers_bench
