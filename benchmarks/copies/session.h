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
/// The name under which peers share their bodies number `index`.
consensus::SharedId shared_id(std::size_t index);

/// s: of a link whose states are `frames` steps of 1/60 s old when they are heard. A little less,
/// so that rounding does not make it one more.
constexpr double latency_of(int frames) { return frames > 0 ? frames / 60.0 - 1e-6 : 0.0; }

/// How a peer goes through time.
struct Pace {
  double hz = 60.0;           ///< steps a second
  double ahead = 0.0;         ///< s, its session clock beside the others'
  double frozen_from = 0.0;   ///< s since the start; no steps from here
  double frozen_until = 0.0;  ///< s, to here
};

/// One peer with its copy of the scene, all bodies shared.
class Site {
 public:
  /// @param owns  this peer says that all bodies are its own
  Site(Copy made, consensus::Transport& transport, const consensus::PeerOptions& options,
       const Pace& pace = {}, bool owns = false,
       const pbd::SolverOptions& steps = {.measure_stages = false});

  consensus::PeerId id;
  Copy copy;
  pbd::Solver solver;
  consensus::Peer peer;
  double cpu = 0.0;  ///< s, that steps have taken, exchange and all
  /// Acts before each step. @param time  s since the start, by the clock on the wall
  std::function<void(Site&, double time)> user;
  /// Before and after the solver's step; see consensus::Peer.
  std::function<void(Site&)> begun;
  std::function<void(Site&, const pbd::StepReport&, double dt)> stepped;

  /// Of the peer's own clock, at this time of the wall's.
  SessionTime clock(double time) const { return kStart + ns(time + pace_.ahead); }

  // Of Session: the next event, ends of steps (0) before beginnings (1).
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
  bool inside_ = false;  ///< the step is computed and waits for its end to come
};

/// Peers of one process in virtual time.
class Session {
 public:
  explicit Session(const consensus::LinkOptions& link, std::uint64_t seed = 1)
      : network(link, seed, kStart) {}

  consensus::VirtualNetwork network;
  std::vector<std::unique_ptr<Site>> sites;

  /// Until this time, s since the start: steps that end then have ended, none begins.
  void run_until(double time);
};

}  // namespace tandem::peers_bench
