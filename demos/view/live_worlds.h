// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runner/virtual_runner.h"
#include "runner/virtual_session.h"
#include "view/mouse.h"
#include "view/pane_watch.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// One session in virtual time; all peers are watched, and each has a user at pages. Same calls,
/// same bits.
/// @par Thread safety  One object: one thread at a time.
class LiveWorlds {
 public:
  /// Scenario and replay must outlive it.
  /// @param replay  the scripted users' inputs; null: their script
  /// @throws as run_virtual
  LiveWorlds(const Scenario& scenario, const DemoOptions& options,
             const std::vector<Input>* replay);
  ~LiveWorlds();
  LiveWorlds(const LiveWorlds&) = delete;
  LiveWorlds& operator=(const LiveWorlds&) = delete;

  std::size_t size() const { return peers_.size(); }
  const Scene& scene(std::size_t peer) const { return peers_[peer].actor->participant().scene(); }
  Mouse& mouse(std::size_t peer) { return *peers_[peer].mouse; }
  const Mouse& mouse(std::size_t peer) const { return *peers_[peer].mouse; }

  /// Runs all events up to `end`, ns.
  void advance_to(consensus::SessionTime end);
  void set_links(const DemoOptions& options);
  void change_rules(const DemoOptions& options);

  /// Shows all worlds at one instant: bodies and marks are interpolated between each peer's two
  /// steps around it.
  /// @param now    ns; not before the last advance_to(), and before the next step
  /// @param out    a frame per peer
  /// @param first  index of the first of them among all panes
  void show(consensus::SessionTime now, std::span<PaneFrame> out, std::size_t first, bool overlays);
  std::vector<PeerRecord> records();
  /// The scores so far of each peer and its users.
  void append_outcomes(std::vector<Outcome>& out);

 private:
  struct Peer {
    Actor* actor = nullptr;
    std::unique_ptr<PaneWatch> watch;
    Mouse* mouse = nullptr;                  ///< owned by the participant
    std::vector<pbd::Pose> before;           ///< of the bodies at the start of the last step
    consensus::SessionTime before_time = 0;  ///< ns
  };
  void keep_poses(Peer& peer);
  /// Poses at `now`. @return s, from then to the time of the peer's world
  double show_poses(const Peer& peer, consensus::SessionTime now,
                    std::vector<pbd::Pose>& out) const;
  void show_overlays(std::size_t peer, std::size_t first, PaneFrame& out);
  void show_springs(std::size_t peer, std::size_t first, double ahead, PaneFrame& out);
  void show_divergence(std::span<PaneFrame> out);

  VirtualSession session_;
  std::vector<Peer> peers_;
  // Scratch.
  std::vector<pbd::Vec3> means_;
  std::vector<double> lengths_;
  std::vector<pbd::Tether::Def> pulls_;
};

}  // namespace tandem::demos::view
