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

/// One peer's view, its record, and the demo's users who see it. Their actions on this scene, which
/// nothing steps, are the peer's input.
class View {
 public:
  /// @param number  of the peer, from 0
  /// @param smoothing  s, time constant of corrections in the view; 0 = at once
  View(const demos::Scenario& scenario, const demos::DemoOptions& options, std::size_t number,
       double smoothing);
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  /// Call before and after a correction of the world at one time.
  void before_correction(const demos::Scene& world);
  void after_correction(const demos::Scene& world);
  /// Moves the view towards the world, by a frame.
  void smooth();
  /// Inputs of the local users. @param now  ns, the beginning of the step  @param dt  s
  Inputs inputs(const demos::Scene& world, consensus::SessionTime now, double dt);
  /// Records a frame and looks for faults, as demos::Participant does. @param end  ns, of the frame
  void keep(const demos::Scene& world, consensus::SessionTime end);
  demos::PeerRecord& record() { return record_; }

 private:
  struct Seat {
    std::unique_ptr<demos::Controls> controls;
    std::unique_ptr<demos::User> user;
  };
  pbd::BodyState shown(const demos::Scene& world, std::size_t body) const;
  /// Number of local users who hold the body.
  int holding(std::size_t body) const;

  const demos::Scenario& scenario_;
  demos::Bounds bounds_;
  double smoothing_;
  demos::Scene scene_;
  consensus::VirtualNetwork nobody_;
  consensus::Peer peer_;
  std::vector<Seat> seats_;
  std::vector<pbd::Pose> before_;   ///< by body, in the world before a correction
  std::vector<pbd::Pose> offsets_;  ///< by body, from the world to the view
  std::unique_ptr<demos::Referee> referee_;
  demos::PeerRecord record_;
  std::uint64_t frames_ = 0;
};

}  // namespace tandem::rollback_bench
