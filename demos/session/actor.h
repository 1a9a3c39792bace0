// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <tuple>

#include "session/participant.h"

namespace tandem::demos {

/// Session time at which virtual runs begin, ns: no stamp is 0 or negative.
inline constexpr consensus::SessionTime kVirtualStart = 1'000'000'000;

/// One peer of a run in virtual time. Peers with a shared clock step at multiples of the session's
/// step time, as net::PhysicsClock does: those of one rate step together.
class Actor {
 public:
  /// @param number  from 0: its id is one more
  Actor(const Scenario& scenario, const DemoOptions& options, std::size_t number,
        consensus::Transport& transport);

  /// Time (ns) and kind of the next event; ends (0) sort before beginnings (1).
  std::tuple<consensus::SessionTime, int> next() const {
    return inside_ ? std::tuple{step_time(step_ + 1), 0} : std::tuple{step_time(step_), 1};
  }
  void act();
  /// No step begins before `time` (ns), as for a program that the system has stopped.
  /// @pre its next event is the beginning of a step
  void sleep_until(consensus::SessionTime time);
  /// ns: time of its world.
  consensus::SessionTime reached() const { return step_time(inside_ ? step_ + 1 : step_); }
  Participant& participant() { return *participant_; }
  const Participant& participant() const { return *participant_; }

 private:
  /// ns: offset of the steps from the grid if they are off it; the first peer's is 0.
  consensus::SessionTime phase(const DemoOptions& options, std::size_t number) const;
  consensus::SessionTime step_time(std::int64_t step) const;

  std::unique_ptr<Participant> participant_;
  consensus::SessionTime first_;
  std::int64_t step_ = 0;
  bool inside_ = false;  ///< the step is computed and waits for its end
};

/// The next to act: by time, then ends of steps before beginnings, then peer. @pre not empty
std::size_t next_actor(std::span<const Actor> actors);

}  // namespace tandem::demos
