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

/// One peer of a demo: its scene, solver and users, and the record of what happens to them.
///
/// One step from t to u (session times, ns): begin(t) when t has come, step(t, u) at once or any
/// time until u, finish(u) when u has come, so that no state is sent before its own time.
/// @par Thread safety  One object: one thread at a time.
class Participant final : private consensus::PeerObserver {
 public:
  /// @param number  from 0: which noise, order and step rate it has
  Participant(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
              std::size_t number, consensus::Transport& transport);

  /// @param user    of the scenario
  /// @param replay  null: the script; else what users did in another run
  void add_user(std::size_t user, const UserOptions& options,
                const std::vector<Input>* replay = nullptr);
  using MakeUser = std::function<std::unique_ptr<User>(Controls&)>;
  /// Somebody who acts as `make` has it: by hand, or as a trace says.
  /// @param user  of nobody else in the session  @param epoch  ns, session time their inputs count
  /// from
  void add_user(std::size_t user, consensus::SessionTime epoch, const MakeUser& make);

  void begin(consensus::SessionTime now);
  void step(consensus::SessionTime now, consensus::SessionTime end);
  void finish(consensus::SessionTime now);
  void leave(consensus::SessionTime now);

  /// Tell of all that happens from now on; null = nobody. Must outlive it, or be set to null.
  void watch_steps_with(StepWatch* watch);

  /// One more observer of what the peer does with remote states. Must outlive it.
  void watch_with(consensus::PeerObserver* observer) { observers_.push_back(observer); }
  /// Agree by other rules from the next step on: a new peer on the same world. Poses, twists and
  /// what the users here hold stay as they are. Lost is what the old peer remembered: the others'
  /// states and springs until they are heard again, who led where, and the predictors' errors; its
  /// authority grows from zero once more.
  void change_rules(const DemoOptions& options);

  const Scene& scene() const { return scene_; }
  /// Whether a user here holds a body by a spring at just this point (m, frame of the body).
  bool holds(std::size_t body, const pbd::Vec3& attachment_l) const;
  const consensus::Peer& peer() const { return *peer_; }
  double step_hz() const { return record_.step_hz; }
  /// s, of all steps so far, as in the record.
  double cpu_s() const { return record_.cpu_s; }
  /// The latest thing that went wrong; "" = nothing has.
  const std::string& fault() const { return fault_; }
  /// Steps after which the world was broken.
  std::uint64_t faults() const { return faults_; }
  /// Whether an update of another peer has come.
  bool has_exchanged() const { return record_.first_exchange != INT64_MAX; }
  /// Keep no tracks until an update has come.
  void record_from_exchange() { wait_for_exchange_ = true; }
  /// Keep nothing that grows with time: for sessions without an end.
  void record_nothing();
  /// s, wall time of the solver's last step.
  double last_step_s() const { return last_step_s_; }
  /// The record so far, with sums and hash brought up to date.
  const PeerRecord& record();

 private:
  void on_estimate(const consensus::EstimateEvent& event) override;
  void make_peer(const DemoOptions& options);
  /// Where the others' users are: at what they move by hand, else where they last held something.
  void place_users();
  void record_bodies(consensus::SessionTime now);
  void look_at_springs(consensus::SessionTime now);
  void watch(consensus::SessionTime now, const pbd::StepReport& report);
  void record_contacts(consensus::SessionTime now);

  /// A user and what they act by.
  struct Seat {
    std::string prefix;  ///< of what they tell, "a_" for user 0
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
  std::optional<consensus::Peer> peer_;                ///< always there; controls keep its address
  std::optional<consensus::NearbyInterest> interest_;  ///< none: all are told of everything
  std::unique_ptr<pbd::TargetSource> targets_;         ///< null: the peer is asked
  std::vector<consensus::PeerObserver*> observers_;
  std::vector<Seat> seats_;
  std::unique_ptr<Referee> referee_;
  std::vector<std::pair<consensus::SharedId, std::uint32_t>> index_;  ///< by id
  collision::ContactEvents events_;
  std::vector<pbd::Vec3> moved_;  ///< m, by body: what two-step coupling did before the step
  std::vector<Controls::Stretch> springs_;  ///< of all users here; only its memory is kept
  std::vector<StretchSample> stretches_;    ///< at the start of the step to come
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

/// ns, by how much the clock of the peer of that number is ahead in virtual time.
consensus::SessionTime clock_ahead(const DemoOptions& options, std::size_t number);

/// The number (from 0) of the peer at which a user sits.
std::size_t seat_of(const DemoOptions& options, std::size_t user);

/// The scene's options for the peer of that number.
/// @param users  how many there are in all
SceneOptions scene_options(const DemoOptions& options, std::size_t number, std::size_t users);

/// What the users are to do again; nothing where they follow their script.
/// @throws std::runtime_error where the file cannot be read
/// @throws std::invalid_argument where it holds something else
std::optional<std::vector<Input>> replayed_inputs(const DemoOptions& options);

/// The users' options; `user` tells their seeds apart.
/// @throws as read_hand_record() where a record is what they do
UserOptions user_options(const DemoOptions& options, std::size_t user,
                         consensus::SessionTime epoch);

}  // namespace tandem::demos
