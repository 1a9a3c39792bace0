// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <vector>

#include "rollback/replica.h"
#include "session/options.h"
#include "session/track.h"
#include "tandem/consensus/virtual_network.h"

namespace tandem::rollback_bench {

/// What is seen at one peer, the record of it, and the demo's users who look at it. What they do to
/// this scene, which nothing steps, is the peer's input: the same people as in the demos, with
/// their eyes and reactions.
class View {
 public:
  /// @param number  of the peer, from 0
  /// @param smoothing  s, time constant in which it follows a correction; 0 = at once
  View(const demos::Scenario& scenario, const demos::DemoOptions& options, std::size_t number,
       double smoothing);
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  /// The world is about to be another one at the same time, and then is.
  void before_correction(const demos::Scene& world);
  void after_correction(const demos::Scene& world);
  /// What is shown comes nearer to the world, by a frame.
  void smooth();
  /// What the users here do. @param now  ns, the beginning of the step  @param dt  s
  Inputs inputs(const demos::Scene& world, consensus::SessionTime now, double dt);
  /// Record a frame and look for faults, as demos::Participant does. @param end  ns, of the frame
  void keep(const demos::Scene& world, consensus::SessionTime end);
  demos::PeerRecord& record() { return record_; }

 private:
  struct Seat {
    std::unique_ptr<demos::Controls> controls;
    std::unique_ptr<demos::User> user;
  };
  pbd::BodyState shown(const demos::Scene& world, std::size_t body) const;
  /// How many of the users here hold the body.
  int holding(std::size_t body) const;

  const demos::Scenario& scenario_;
  demos::Bounds bounds_;
  double smoothing_;
  demos::Scene scene_;
  consensus::VirtualNetwork nobody_;
  consensus::Peer peer_;
  std::vector<Seat> seats_;
  std::vector<pbd::Pose> before_;   ///< by body, in the world before a correction
  std::vector<pbd::Pose> offsets_;  ///< by body, from the world to what is shown
  std::unique_ptr<demos::Referee> referee_;
  demos::PeerRecord record_;
  std::uint64_t frames_ = 0;
};

}  // namespace tandem::rollback_bench
