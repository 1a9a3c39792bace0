// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/options.h"
#include "common/track.h"
#include "scenes/scenario.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos {

/// One peer of a demo: its scene, solver and users, and the record of what happens to them.
///
/// One step from t to u (session times, ns): begin(t) when t has come, step(t, u) at once or any
/// time until u, finish(u) when u has come, so that no state is sent before its own time.
/// @par Thread safety  One object: one thread at a time.
class Participant final : private consensus::PeerObserver {
 public:
  /// Beyond these a world counts as broken.
  static constexpr double kMaxDistance = 20.0;  ///< m, from the origin
  static constexpr double kMaxSpeed = 20.0;     ///< m/s

  /// @param number  from 0: which noise, order and step rate it has
  Participant(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
              std::size_t number, consensus::Transport& transport);

  /// @param user  of the scenario
  void add_user(std::size_t user, const UserOptions& options);

  void begin(consensus::SessionTime now);
  void step(consensus::SessionTime now, consensus::SessionTime end);
  void finish(consensus::SessionTime now);
  void leave(consensus::SessionTime now) { peer_.leave(now); }

  const Scene& scene() const { return scene_; }
  double step_hz() const { return record_.step_hz; }
  const std::string& fault() const { return record_.fault; }
  /// Whether an update of another peer has come.
  bool has_exchanged() const { return record_.first_exchange != INT64_MAX; }
  /// Keep no tracks until an update has come.
  void record_from_exchange() { wait_for_exchange_ = true; }
  /// The record so far, with sums and hash brought up to date.
  const PeerRecord& record();

 private:
  void on_prediction(consensus::PeerId from, const consensus::SharedId& body,
                     consensus::SessionTime now, const pbd::Vec3& predicted_position,
                     double age) override;
  void record_bodies(consensus::SessionTime now);
  void watch(consensus::SessionTime now, const pbd::StepReport& report);
  void set_fault(consensus::SessionTime now, const std::string& text);

  const Scenario& scenario_;
  Scene scene_;
  pbd::Solver solver_;
  consensus::Peer peer_;
  std::vector<std::unique_ptr<User>> users_;
  std::vector<std::pair<consensus::SharedId, std::uint32_t>> index_;  ///< by id
  PeerRecord record_;
  consensus::SessionTime epoch_ = 0;
  std::uint64_t steps_ = 0;
  bool started_ = false;
  bool wait_for_exchange_ = false;
};

/// The scene's options for the peer of that number.
SceneOptions scene_options(const DemoOptions& options, std::size_t number);

/// The users' options; `user` tells their seeds apart.
UserOptions user_options(const DemoOptions& options, std::size_t user,
                         consensus::SessionTime epoch);

}  // namespace tandem::demos
