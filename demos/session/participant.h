// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenes/scenario.h"
#include "session/options.h"
#include "session/physics.h"
#include "session/signals.h"
#include "session/step_watch.h"
#include "session/track.h"
#include "tandem/collision/contact_events.h"
#include "tandem/consensus/nearby_interest.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/report.h"

namespace tandem::demos {

/// One peer of a demo: its scene, solver and users, and the record of the run.
///
/// One step from t to u (session times, ns): begin(t) at t, step(t, u) at any time until u,
/// finish(u) at u, so that no state is sent before its own time.
/// @par Thread safety  One object: one thread at a time.
class Participant final : private consensus::PeerObserver {
 public:
  /// @param number  from 0: selects noise, order and step rate
  Participant(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
              std::size_t number, consensus::Transport& transport);

  /// @param user    of the scenario
  /// @param replay  null: the script; otherwise users' inputs of another run
  void add_user(std::size_t user, const UserOptions& options,
                const std::vector<Input>* replay = nullptr);
  using MakeUser = std::function<std::unique_ptr<User>(Controls&)>;
  /// Adds a user made by `make`: at a page, or from a trace.
  /// @param user  unique in the session  @param epoch  ns, session time 0 of their inputs
  void add_user(std::size_t user, consensus::SessionTime epoch, const MakeUser& make);

  void begin(consensus::SessionTime now);
  void step(consensus::SessionTime now, consensus::SessionTime end);
  void finish(consensus::SessionTime now);
  void leave(consensus::SessionTime now);

  /// Reports all later events; null = none. Must outlive it, or be set to null.
  void watch_steps_with(StepWatch* watch);

  /// Adds an observer of remote states. Must outlive it.
  void watch_with(consensus::PeerObserver* observer) { observers_.push_back(observer); }
  /// Switches rules from the next step on: a new peer on the same world. Poses, twists and the
  /// local users' springs stay. The old peer's memory is lost: others' states and springs until
  /// heard again, leads, and predictors' errors; its authority grows from zero again.
  void change_rules(const DemoOptions& options);

  const Scene& scene() const { return scene_; }
  /// True if a local user holds a body by a spring at exactly this point (m, frame of the body).
  bool holds(std::size_t body, const pbd::Vec3& attachment_l) const;
  const consensus::Peer& peer() const { return *peer_; }
  double step_hz() const { return record_.step_hz; }
  /// s, of all steps so far, as in the record.
  double cpu_s() const { return record_.cpu_s; }
  /// The latest fault; "" = none.
  const std::string& fault() const { return fault_; }
  /// Steps after which the world was broken.
  std::uint64_t faults() const { return faults_; }
  /// True once an update of another peer has come.
  bool has_exchanged() const { return record_.first_exchange != INT64_MAX; }
  /// Keeps no tracks until an update has come.
  void record_from_exchange() { wait_for_exchange_ = true; }
  /// Keeps nothing that grows with time: for endless sessions.
  void record_nothing();
  /// s, wall time of the solver's last step.
  double last_step_s() const { return last_step_s_; }
  /// The record so far, with current sums and hash.
  const PeerRecord& record();

 private:
  void on_estimate(const consensus::EstimateEvent& event) override;
  void make_peer(const DemoOptions& options);
  /// Positions of the others' users: their own bodies, otherwise their last held body.
  void place_users();
  void record_bodies(consensus::SessionTime now);
  void look_at_springs(consensus::SessionTime now);
  void watch(consensus::SessionTime now, const pbd::StepReport& report);
  void record_contacts(consensus::SessionTime now);

  struct Seat {
    std::string prefix;  ///< of the names of their results, "a_" for user 0
    std::unique_ptr<Controls> controls;
    std::unique_ptr<User> user;
  };
  void sit_down(std::size_t user, consensus::SessionTime epoch, std::string prefix,
                const MakeUser& make);

  const Scenario& scenario_;
  std::size_t number_;
  Bounds bounds_;
  Scene scene_;
  BodiesBySlot bodies_;
  std::unique_ptr<Physics> physics_;
  Signals signals_;
  std::optional<consensus::Peer> peer_;                ///< always set; controls keep its address
  std::optional<consensus::NearbyInterest> interest_;  ///< none: all bodies are sent to all
  std::unique_ptr<pbd::TargetSource> targets_;         ///< null: the peer is asked
  std::vector<consensus::PeerObserver*> observers_;
  std::vector<Seat> seats_;
  std::unique_ptr<Referee> referee_;
  std::vector<std::pair<consensus::SharedId, std::uint32_t>> index_;  ///< by id
  collision::ContactEvents events_;
  std::vector<pbd::Vec3> moved_;  ///< m, by body: displacement by two-step coupling before the step
  std::vector<Controls::Stretch> springs_;  ///< of all local users; scratch, kept for its capacity
  std::vector<StretchSample> stretches_;    ///< at the start of the coming step
  PeerRecord record_;
  consensus::SessionTime epoch_ = 0;
  consensus::SessionTime clock_ahead_ = 0;  ///< ns, of the peer's clock; all else is in true time
  std::uint64_t steps_ = 0;
  std::uint64_t faults_ = 0;
  std::string fault_;
  double last_step_s_ = 0.0;
  bool recording_ = true;
  bool started_ = false;
  bool wait_for_exchange_ = false;
  StepWatch* watch_ = nullptr;
};

/// ns, lead in virtual time of the clock of the peer of that number.
consensus::SessionTime clock_ahead(const DemoOptions& options, std::size_t number);

/// The number (from 0) of a user's peer.
std::size_t seat_of(const DemoOptions& options, std::size_t user);

/// The scene's options for the peer of that number.
/// @param users  total number
SceneOptions scene_options(const DemoOptions& options, std::size_t number, std::size_t users);

/// The users' inputs to replay; nothing if they follow their script.
/// @throws std::runtime_error if the file cannot be read
/// @throws std::invalid_argument if its content is invalid
std::optional<std::vector<Input>> replayed_inputs(const DemoOptions& options);

/// The users' options; `user` varies the seed.
/// @throws as read_hand_record() for a recorded hand
UserOptions user_options(const DemoOptions& options, std::size_t user,
                         consensus::SessionTime epoch);

}  // namespace tandem::demos
