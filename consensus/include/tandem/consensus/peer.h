// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/influence.h"
#include "tandem/consensus/plausibility.h"
#include "tandem/consensus/predictor.h"
#include "tandem/consensus/replay.h"
#include "tandem/consensus/robust.h"
#include "tandem/consensus/shared_id.h"
#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// How a user's spring acts, [friston] Secs. 3.5, 4.3 and 7.1.
enum class InputMode : std::uint8_t {
  Soft,        ///< all peers simulate it
  Asymmetric,  ///< this peer alone does; the others see what it does to the body
  /// None does: the body is where the hand drags it, physics has no say. What is sent is this
  /// user's own state of it, what is shown the mean of all users'. Stable whatever the delay.
  Hard,
};

/// What remote states do to the bodies here. OnePass is what this library is about; the others are
/// what it is compared with, on the same engine and behind the same prediction and rules of
/// influence. Bodies that have an owner from the start (ShareDef::owner) follow their owner in all
/// of them: like a user's spring they are an input, not a matter of agreement.
enum class Coupling : std::uint8_t {
  OnePass,  ///< remote states are targets in the solver's pass
  TwoStep,  ///< the paper's scheme: average first, [friston] Secs. 4.2 and 4.6, then a plain step
  None,     ///< states are sent and never used: what copies do that only users' springs join
  /// Transactional: a body belongs to one peer, the others put it where its owner has it. It passes
  /// to whoever acts on it last, by a request and a grant, a round trip after the act; what nobody
  /// has asked for is the lowest id's.
  SingleOwner,
};

enum class StateFormat : std::uint8_t {
  Full,     ///< as StateUpdate has it, 93 bytes
  Compact,  ///< rounded, about 27 bytes where a body moves and 14 where it rests, see compact.h
};

/// What stamps of others are read by.
enum class TimestampSource : std::uint8_t {
  /// As they are: all clocks show the session's time. Of a sender all of whose stamps have been
  /// more
  /// than 10 s old or further ahead than PeerOptions::max_future for a second (its clock was set,
  /// and it started again) they are read as with Arrival, until they are right again.
  Sender,
  /// By when they come, half a round trip before: no two clocks need to agree, see SenderClocks.
  /// The transport says when and how long; where it does not, they are dated by the step that finds
  /// them, and no way is assumed.
  Arrival,
};

/// Which states are sent, to each of the others, and in what form. docs/protocol.md has the rules.
struct TANDEM_API SendOptions {
  StateFormat format = StateFormat::Full;
  /// kbit/s to each of the others, and never more than the transport says that the way there bears
  /// (UDP does); 0 = no other limit. What does not fit waits: what this peer's user holds or leads
  /// comes first, then what the other side expects most wrongly, then what rests.
  /// Where nothing but defaults is set here, all is sent and the transport sorts it out.
  double kbit_per_s = 0.0;
  /// m: a state is sent where the last one that was sent, carried on by its velocity (and gravity,
  /// where nothing touches it), is off by more; 0 = every time.
  double tolerance = 0.0;
  double angle_tolerance = 0.02;  ///< rad, the same of orientations; only with `tolerance`
  double refresh = 0.1;           ///< s: what moves is sent at least so often; likewise
  /// s: what rests is said once, reliably, and repeated so often; likewise
  double rest_refresh = 5.0;

  /// Whether not everything is sent every time.
  bool selects() const { return kbit_per_s > 0.0 || tolerance > 0.0; }
  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

struct TANDEM_API PeerOptions {
  double update_hz = 60.0;  ///< states sent each second, > 0
  TimestampSource timestamps = TimestampSource::Sender;
  SendOptions sending = {};
  InfluenceOptions influence = {};
  PredictorKind predictor = PredictorKind::Replay;
  ReplayOptions replay = {};
  PredictorOptions prediction = {};
  /// Of the application's own making, in place of `predictor`; null = that one. Where what it says
  /// is not finite the state counts as it was stamped. Peers of one session need not have the same.
  std::shared_ptr<const Predictor> own_predictor = nullptr;
  /// How far others are believed.
  RobustOptions robust = {};
  PlausibilityOptions plausibility = {};
  Coupling coupling = Coupling::OnePass;
  /// Of TwoStep: leave positions, orientations and velocities alone, each by itself, that differ by
  /// less than 1 mm, 1 degree, 1 cm/s and 0.01 rad/s, as in [friston] Sec. 4.6. Without, only
  /// bodies that rest are left alone, on the terms on which one pass lets them sleep: slow and
  /// within 1 mm and 1 degree for half a second.
  bool two_step_thresholds = true;
  /// Whose user was the last to act on a body leads, see docs/ARCHITECTURE.md; false: nobody does.
  bool initiative = true;
  /// Where no average brings copies together (they rest on different faces, or something solid is
  /// between them) one peer's are elected; false: they are averaged all the same.
  bool arbitration = true;
  /// Of this peer's springs. With Hard others are believed as well that they move a body by hand:
  /// they count as its owners while they do.
  InputMode mode = InputMode::Soft;
  /// s: own influence grows from 0 to full over this time after the first step, against others and
  /// against remote states: a newcomer takes over what the others know before it is heard.
  double authority_ramp = 1.0;
  /// s: states that are stamped further ahead of the own clock are refused: one of the two is
  /// wrong, and what a hand will do cannot be told. Above the longest step of any peer.
  double max_future = 0.25;
  /// s: springs of a peer that has fallen silent are let go after this.
  double spring_timeout = 1.0;
  /// s: an anchor is carried on by its velocity no longer than this; 0 = not at all.
  double max_anchor_extrapolation = 0.3;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// A body that all peers know under one id.
struct TANDEM_API ShareDef {
  SharedId id = {};
  pbd::BodyId body = {};
  /// Whose hand moves it, where it is nobody's but theirs: that peer's states count 100 % at the
  /// others and the others' count nothing there. A body that is kinematic there may be so here:
  /// it goes along, and pushes as any kinematic body does.
  std::optional<PeerId> owner = {};
  /// Whether it matters how the body is turned: not of a uniform sphere that is drawn plain. Else
  /// the compact format leaves it out, and nothing here is turned to agree.
  bool orientation = true;
};

/// A user's spring on a shared body.
struct TANDEM_API GrabDef {
  SharedId body = {};
  pbd::Vec3 attachment_l = pbd::Vec3::Zero();  ///< m, frame of the body
  pbd::Vec3 anchor_w = pbd::Vec3::Zero();      ///< m, world
  double stiffness = 500.0;                    ///< N/m
  double damping = 20.0;                       ///< N s/m
  double max_force = 1e6;                      ///< N
  std::optional<InputMode> mode = {};          ///< nullopt = the peer's
};

/// Names one of this peer's own springs.
struct TANDEM_API GrabId {
  std::uint32_t spring = 0;  ///< 0 = none
  friend bool operator==(const GrabId&, const GrabId&) = default;
};

/// What an application does to a shared body at once: pose and twist are set first, then the
/// impulses are added.
struct TANDEM_API ActDef {
  SharedId body = {};
  pbd::Vec3 impulse = pbd::Vec3::Zero();          ///< N s, world, at the centre of mass
  pbd::Vec3 angular_impulse = pbd::Vec3::Zero();  ///< N m s, world
  std::optional<pbd::Pose> pose = {};             ///< of the centre of mass, world
  std::optional<pbd::Twist> twist = {};           ///< world
  /// Of what all peers do by themselves, as a script's blast: acts on a body under one name are
  /// one act within a second, whoever does them. 0 = only this peer does it.
  std::uint64_t name = 0;
};

/// What went to one of the others.
struct TANDEM_API LinkStats {
  PeerId to = 0;
  std::uint64_t bytes = 0;      ///< of packets with states and names
  std::uint64_t states = 0;     ///< sent
  std::uint64_t deferred = 0;   ///< for want of budget; a state that waits is counted each time
  std::uint64_t unchanged = 0;  ///< not sent, since the other side knows them well enough
};

/// Seconds and counts since the start.
struct TANDEM_API PeerStats {
  double parse_s = 0.0;                 ///< CPU time in decoding packets
  double process_s = 0.0;               ///< CPU time in sorting updates in
  double aggregate_s = 0.0;             ///< CPU time in prediction and fusion
  std::uint64_t updates_received = 0;   ///< state updates decoded
  std::uint64_t bodies_aggregated = 0;  ///< shared bodies times steps with at least one estimate
  std::uint64_t packets_received = 0;
  std::uint64_t packets_rejected = 0;  ///< not decodable; their sender was dropped
  std::uint64_t unknown_ids = 0;
  std::uint64_t unknown_indices = 0;  ///< compact states whose names have not come; dropped
  std::uint64_t springs_refused = 0;  ///< unknown body, or too many
  std::uint64_t acts_refused = 0;     ///< unknown or owned body, too old, or too many; own ones too
  std::uint64_t bytes_sent = 0;
  InboxCounters inbox = {};
  ReplayStats replay = {};
  /// Bodies that were taken over from an elected peer, since copies rested in different places.
  std::uint64_t bodies_placed = 0;
  /// Bodies that now rest elsewhere than the elected peer's do: taking them over was in vain, since
  /// the surroundings are others.
  std::uint64_t bodies_apart = 0;
  /// By peer; empty where every state goes to everybody in full, see SendOptions.
  std::vector<LinkStats> links = {};
};

/// A remote state that is about to be used, with all that predictors may go by.
struct TANDEM_API EstimateEvent {
  PeerId from = 0;
  const StateUpdate& update;
  const MotionHistory& own;
  const PredictionContext& context;
  const Prediction& prediction;
  /// m, world: where the body is taken to be now. Where its state is replayed that is the own
  /// position plus the difference of both at the stamp.
  pbd::Vec3 position;
  double age = 0.0;  ///< s, from the sender's stamp
};

/// Watches what a peer does with remote states; for recorders.
class TANDEM_API PeerObserver {
 public:
  virtual ~PeerObserver() = default;
  /// Called from before_step. References are valid during the call.
  virtual void on_estimate(const EstimateEvent& event) = 0;
};

/// Who is told of which body; all peers of everything where nobody says otherwise.
class TANDEM_API Interest {
 public:
  virtual ~Interest() = default;
  /// Whether the state of a body goes to that peer. Called from after_step, for each update.
  virtual bool concerns(PeerId to, const SharedId& id, const pbd::Pose& pose) const = 0;
};

/// A body that somebody's user holds by a spring.
struct TANDEM_API HeldBody {
  PeerId user = 0;  ///< at that peer
  pbd::BodyId body = {};
  pbd::Vec3 anchor_w = pbd::Vec3::Zero();  ///< m, world: where the hand is
};

/// A state of a body that is not shared here.
struct TANDEM_API UnknownState {
  PeerId from = 0;
  StateUpdate update = {};
};

/// One participant: shares bodies of a world with the other peers of a transport.
///
/// Each step:  peer.before_step(now);  solver.step(world, dt);  peer.after_step(now + dt);
/// with session times. One-pass coupling hands targets to the solver as the world's TargetSource;
/// the others move bodies, or pull at them, in before_step.
///
/// Peers' bytes are untrusted: what does not decode is counted and its sender dropped with the
/// reason; unknown ids are counted and ignored; values are bounded by the codec.
/// @par Thread safety  Distinct objects: safe. One object: the thread that steps its world.
class TANDEM_API Peer final : public pbd::TargetSource {
 public:
  /// Both must outlive the peer and stay where they are. Becomes the world's target source and adds
  /// a block of tethers, which goes with the peer.
  /// @throws std::invalid_argument where the options are not valid
  Peer(pbd::World& world, Transport& transport, const PeerOptions& options = {});
  ~Peer() override;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// @throws std::invalid_argument for an unknown or static body, an invalid id, or where either is
  ///   shared already
  void share(const ShareDef& def);
  /// Change who owns a shared body; nullopt = everybody. @throws as share
  void set_owner(const SharedId& id, std::optional<PeerId> owner);
  /// Who owns a shared body now: as it was said, or as Coupling::SingleOwner has it; nullopt =
  /// nobody.
  /// @throws std::invalid_argument where it is not shared
  std::optional<PeerId> owner(const SharedId& id) const;

  /// Share it no longer: states of it count as unknown, own springs on it are released.
  /// @throws std::invalid_argument where it is not shared
  void unshare(const SharedId& id);
  /// Stamp (ns) of the newest state that a peer has sent of a body; nullopt where there is none.
  std::optional<SessionTime> heard(const SharedId& id, PeerId from) const;
  /// States of bodies that are not shared here, of the last before_step: what an application may
  /// make bodies from. At most kMaxUnknown, the first ones; untrusted as all that peers say.
  std::span<const UnknownState> unknown() const;
  static constexpr std::size_t kMaxUnknown = 1024;

  /// Hold a shared body with a spring. @throws std::invalid_argument naming field, value and rule
  GrabId grab(const GrabDef& def);
  /// Move the hand. `anchor_w` (m) is where it is at `now`, the start of the step to come.
  void move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now);
  void release(GrabId id);
  /// Whether the spring still pulls: false once it is released or its body is gone.
  bool holds(GrabId id) const;
  /// Whether any user's spring, own or remote, holds the body.
  bool held(const SharedId& id) const;

  /// Do something to a shared body at once, here and, as of the same session time, at all others:
  /// a kick, a blast, a respawn. To be called between steps. What all peers do alike in each step,
  /// as wind, is no act: World has it. As hands do, acts make a body no faster than
  /// RobustOptions::max_pull_speed, or than it is, and it spins with no more than
  /// max_spin_correction; the others take 256 of one peer a second and 512 at once, of those with a
  /// pose a quarter. What is more is done here alone (PeerStats::acts_refused).
  /// @throws std::invalid_argument naming field, value and rule; also where the body is not shared,
  ///   not dynamic, or another peer's
  void act(const ActDef& def);

  /// What all users hold, own and remote; one for each spring, appended.
  void held_bodies(std::vector<HeldBody>& out) const;
  /// The instance of a shared body here; an invalid id where it is not shared.
  pbd::BodyId body_of(const SharedId& id) const;
  /// One state for all that is known of a body now, own and others', with the sum of their weights:
  /// see fuse() of summary.h. nullopt where it is not shared, or nothing of it has a weight.
  std::optional<StateUpdate> fused(const SharedId& id) const;

  /// Take in what has come and set this step's springs and estimates. `now`: session time of the
  /// world before the step, ns, above 0 (0 means "never" in what is remembered).
  void before_step(SessionTime now);
  /// Remember and, when it is time, send. `now`: session time of the world after the step, ns.
  void after_step(SessionTime now);
  /// Tell the others that this peer goes: its springs and states end there.
  void leave(SessionTime now);

  // For bodies that another engine steps. The world is then a view of them: before_step moves it
  // (with TwoStep or SingleOwner; the others ask the solver for something), the other engine is
  // told what has changed, pulls by these springs and steps, and poses and twists are copied back
  // before after_step.

  /// All users' springs, own and remote, as they pull during the step to come; appended. Anchors
  /// are of its start and go on with their velocity.
  void springs(std::vector<pbd::Tether::Def>& out) const;
  /// Two bodies of the world pushed each other in the step that was just made; an invalid id stands
  /// for anything else. To be called before after_step.
  void note_contact(pbd::BodyId a, pbd::BodyId b = {});

  const PeerStats& stats() const;
  /// What each of the others has sent that was not believed, by ascending id; who has left stays.
  /// Valid until the next step.
  std::span<const PeerReport> reports() const;
  void set_observer(PeerObserver* observer);
  /// Must outlive the peer or be set to null. Called where states are replayed.
  void set_replay_hook(ReplayHook* hook);
  /// Must outlive the peer or be set to null.
  void set_interest(const Interest* interest);

  // pbd::TargetSource
  void collect(const pbd::World& world, double dt, const pbd::SolverOptions& options,
               std::vector<pbd::PoseTarget>& out) override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::consensus
