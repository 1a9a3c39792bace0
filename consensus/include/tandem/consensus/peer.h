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

/// How a user's spring acts on a body, [friston] Secs. 3.5, 4.3 and 7.1.
enum class InputMode : std::uint8_t {
  Soft,        ///< all peers simulate it
  Asymmetric,  ///< only this peer simulates it; the others see its effect on the body
  /// No peer simulates it: the body follows the hand, without physics. This user's own state is
  /// sent, the mean of all users' is shown. Stable at any delay.
  Hard,
};

/// How remote states act on the bodies here. OnePass is the method of this library. The others are
/// comparison baselines on the same engine, with the same prediction and rules of influence. A body
/// with an owner from the start (ShareDef::owner) follows it in all of them.
enum class Coupling : std::uint8_t {
  OnePass,  ///< remote states are targets in the solver's pass
  TwoStep,  ///< the paper's scheme: average first, [friston] Secs. 4.2 and 4.6, then a plain step
  None,     ///< states are sent and never used: copies are coupled by users' springs alone
  /// Transactional: each body belongs to one peer, and the others copy its state. Ownership passes
  /// to the peer that acts last, by a request and a grant, one round trip after the act. An
  /// unclaimed body belongs to the lowest id.
  SingleOwner,
};

enum class StateFormat : std::uint8_t {
  Full,     ///< as StateUpdate has it, 93 bytes
  Compact,  ///< rounded, about 27 bytes for a moving body and 14 for a resting one, see compact.h
};

/// How stamps of other peers are dated.
enum class TimestampSource : std::uint8_t {
  /// By the stamps themselves: all clocks show session time. If all stamps of a sender are more
  /// than 10 s old, or further ahead than PeerOptions::max_future, for one second (its clock was
  /// set, or it was restarted), they are dated as with Arrival until they are right again.
  Sender,
  /// By arrival less half a round trip: clocks need not agree, see SenderClocks. The transport
  /// reports both. Without its report a packet is dated by the step that reads it, with no delay.
  Arrival,
};

/// Which states are sent to each peer, and in what format. docs/protocol.md has the rules.
struct TANDEM_API SendOptions {
  StateFormat format = StateFormat::Full;
  /// kbit/s to each peer, and never more than the transport reports for its path (UDP does); 0 = no
  /// other limit. States that do not fit wait: first go bodies that this peer's user holds or
  /// leads, then those that the receiver predicts worst, then resting ones. If all options are at
  /// their defaults, every state is sent and the transport drops what does not fit.
  double kbit_per_s = 0.0;
  /// m: a state is sent if the last one sent, extrapolated by its velocity (and gravity if nothing
  /// touches the body), is off by more; 0 = always.
  double tolerance = 0.0;
  double angle_tolerance = 0.02;  ///< rad, tolerance of orientations; only with `tolerance`
  double refresh = 0.1;           ///< s: longest interval while moving; only with `tolerance`
  /// s: a resting body is sent once, reliably, and repeated at this interval; only with `tolerance`
  double rest_refresh = 5.0;

  /// Whether some states are left out.
  bool selects() const { return kbit_per_s > 0.0 || tolerance > 0.0; }
  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

struct TANDEM_API PeerOptions {
  double update_hz = 60.0;  ///< states sent per second, > 0
  TimestampSource timestamps = TimestampSource::Sender;
  SendOptions sending = {};
  InfluenceOptions influence = {};
  PredictorKind predictor = PredictorKind::Replay;
  ReplayOptions replay = {};
  PredictorOptions prediction = {};
  /// An application's predictor, used instead of `predictor`; null = none. If its result is not
  /// finite, the state is used as stamped. Peers of a session may differ.
  std::shared_ptr<const Predictor> own_predictor = nullptr;
  /// How far other peers are believed.
  RobustOptions robust = {};
  PlausibilityOptions plausibility = {};
  Coupling coupling = Coupling::OnePass;
  /// TwoStep only: ignore differences below 1 mm, 1 degree, 1 cm/s and 0.01 rad/s, each by itself,
  /// as in [friston] Sec. 4.6. If false, only resting bodies are left alone, by the criterion that
  /// one pass has for sleep: slow and within 1 mm and 1 degree for half a second.
  bool two_step_thresholds = true;
  /// Whether the only peer whose user acts on a body, or acted on it last, leads it, see
  /// docs/ARCHITECTURE.md.
  bool initiative = true;
  /// Whether one peer's copies are elected if no average brings copies together (they rest on
  /// different faces, or something solid is between them); false: they are averaged.
  bool arbitration = true;
  /// Mode of this peer's springs. With Hard other peers' claims to move a body by hand are believed
  /// too: they count as its owners meanwhile.
  InputMode mode = InputMode::Soft;
  /// s: after the first step this peer's influence on others, and the weight of its own copies
  /// against remote states, grow from 0 to full over this time: a newcomer takes over the session's
  /// state before it counts.
  double authority_ramp = 1.0;
  /// s: states stamped further ahead of this peer's clock are refused, as one of the two clocks is
  /// wrong and a hand's motion cannot be predicted. Must exceed the longest step of any peer.
  double max_future = 0.25;
  /// s: springs of a peer that has been silent for this long are released.
  double spring_timeout = 1.0;
  /// s: longest time for which an anchor is extrapolated by its velocity; 0 = not at all.
  double max_anchor_extrapolation = 0.3;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// A body that all peers know under one id.
struct TANDEM_API ShareDef {
  SharedId id = {};
  pbd::BodyId body = {};
  /// The peer whose hand alone moves the body: its states count 100 % at all others, and the
  /// others' states are ignored there. A body that is kinematic there may be kinematic here: it
  /// follows, and pushes like any kinematic body.
  std::optional<PeerId> owner = {};
  /// Whether the orientation matters: not for a uniform sphere without a texture. If false, the
  /// compact format omits it, and it is not agreed on.
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

/// Handle of one of this peer's springs.
struct TANDEM_API GrabId {
  std::uint32_t spring = 0;  ///< 0 = none
  friend bool operator==(const GrabId&, const GrabId&) = default;
};

/// An instantaneous act of the application on a shared body: pose and twist are set first, then the
/// impulses are added.
struct TANDEM_API ActDef {
  SharedId body = {};
  pbd::Vec3 impulse = pbd::Vec3::Zero();          ///< N s, world, at the centre of mass
  pbd::Vec3 angular_impulse = pbd::Vec3::Zero();  ///< N m s, world
  std::optional<pbd::Pose> pose = {};             ///< of the centre of mass, world
  std::optional<pbd::Twist> twist = {};           ///< world
  /// Name of an act that all peers do by themselves, such as a script's blast: acts on a body under
  /// one name within a second count once. 0 = only this peer does it.
  std::uint64_t name = 0;
};

/// Traffic to one peer.
struct TANDEM_API LinkStats {
  PeerId to = 0;
  std::uint64_t bytes = 0;      ///< of packets with states and indices
  std::uint64_t states = 0;     ///< sent
  std::uint64_t deferred = 0;   ///< for lack of budget; counted in each step that a state waits
  std::uint64_t unchanged = 0;  ///< not sent: the receiver's prediction is good enough
};

/// Seconds and counts since the start.
struct TANDEM_API PeerStats {
  double parse_s = 0.0;                 ///< CPU time in decoding packets
  double process_s = 0.0;               ///< CPU time in filing updates
  double aggregate_s = 0.0;             ///< CPU time in prediction and fusion
  std::uint64_t updates_received = 0;   ///< state updates decoded
  std::uint64_t bodies_aggregated = 0;  ///< shared bodies times steps with at least one estimate
  std::uint64_t packets_received = 0;
  std::uint64_t packets_rejected = 0;  ///< not decodable; their sender was dropped
  std::uint64_t unknown_ids = 0;
  std::uint64_t unknown_indices = 0;  ///< compact states whose index is not known here; dropped
  std::uint64_t springs_refused = 0;  ///< unknown body, or too many
  std::uint64_t acts_refused = 0;     ///< unknown or owned body, too old, or too many; own ones too
  std::uint64_t bytes_sent = 0;
  InboxCounters inbox = {};
  ReplayStats replay = {};
  /// Bodies placed where an elected peer has them, since copies rested in different places.
  std::uint64_t bodies_placed = 0;
  /// Bodies that came to rest elsewhere than the elected peer's after being placed: their
  /// surroundings differ.
  std::uint64_t bodies_apart = 0;
  /// By peer; empty if every state goes to every peer in full, see SendOptions.
  std::vector<LinkStats> links = {};
};

/// A remote state that is about to be used, with the inputs of its prediction.
struct TANDEM_API EstimateEvent {
  PeerId from = 0;
  const StateUpdate& update;
  const MotionHistory& own;
  const PredictionContext& context;
  const Prediction& prediction;
  /// m, world: estimated position now. If the state is replayed, the local position plus the
  /// difference of both at the stamp.
  pbd::Vec3 position;
  double age = 0.0;  ///< s, from the sender's stamp
};

/// Observes how a peer uses remote states; for recorders.
class TANDEM_API PeerObserver {
 public:
  virtual ~PeerObserver() = default;
  /// Called from before_step. References are valid during the call.
  virtual void on_estimate(const EstimateEvent& event) = 0;
};

/// Selects the bodies whose states a peer receives; without one every peer receives all.
class TANDEM_API Interest {
 public:
  virtual ~Interest() = default;
  /// Whether the state of a body is sent to `to`. Called from after_step, for each update.
  virtual bool concerns(PeerId to, const SharedId& id, const pbd::Pose& pose) const = 0;
};

/// A body held by a user's spring.
struct TANDEM_API HeldBody {
  PeerId user = 0;  ///< the peer of that user
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
/// with session times. One-pass coupling gives targets to the solver as the world's TargetSource;
/// the other couplings move or pull bodies in before_step.
///
/// Bytes from peers are untrusted: a packet that does not decode is counted and its sender dropped
/// with the reason, unknown ids are counted and ignored, and the codec bounds values.
/// @par Thread safety  Distinct objects: safe. One object: the thread that steps its world.
class TANDEM_API Peer final : public pbd::TargetSource {
 public:
  /// World and transport must outlive the peer and not be moved. It becomes the world's target
  /// source and adds a block of tethers, which it removes in the end.
  /// @throws std::invalid_argument if the options are not valid
  Peer(pbd::World& world, Transport& transport, const PeerOptions& options = {});
  ~Peer() override;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// @throws std::invalid_argument for an unknown or static body, an invalid id, or if either is
  /// shared already
  void share(const ShareDef& def);
  /// Change the owner of a shared body; nullopt = none. @throws as share
  void set_owner(const SharedId& id, std::optional<PeerId> owner);
  /// The present owner of a shared body, as set or as Coupling::SingleOwner has decided; nullopt =
  /// none.
  /// @throws std::invalid_argument if it is not shared
  std::optional<PeerId> owner(const SharedId& id) const;

  /// Stop sharing: states of it count as unknown, own springs on it are released.
  /// @throws std::invalid_argument if it is not shared
  void unshare(const SharedId& id);
  /// Stamp (ns) of the newest state that a peer has sent of a body; nullopt if none came.
  std::optional<SessionTime> heard(const SharedId& id, PeerId from) const;
  /// States of bodies that are not shared here, from the last before_step: the application may
  /// create bodies from them. The first kMaxUnknown at most; untrusted.
  std::span<const UnknownState> unknown() const;
  static constexpr std::size_t kMaxUnknown = 1024;

  /// Hold a shared body with a spring. @throws std::invalid_argument naming field, value and rule
  GrabId grab(const GrabDef& def);
  /// Move the hand. `anchor_w` (m) is where it is at `now`, the start of the step to come.
  void move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now);
  void release(GrabId id);
  /// Whether the spring still pulls: false once it is released or its body is removed.
  bool holds(GrabId id) const;
  /// Whether any user's spring, own or remote, holds the body.
  bool held(const SharedId& id) const;

  /// Act on a shared body instantaneously, here and, as of the same session time, at all peers: a
  /// kick, a blast, a respawn. Call it between steps. For what all peers do alike in each step,
  /// such as wind, use World. Acts have the limits of hands: a body gets no faster than
  /// RobustOptions::max_pull_speed, or than it is, and spins with at most max_spin_correction.
  /// Peers accept 256 acts per second and 512 at once from one peer; an act with a pose counts as
  /// four. Acts beyond that are done here alone (PeerStats::acts_refused).
  /// @throws std::invalid_argument naming field, value and rule; also if the body is not shared,
  /// not dynamic, or owned by another peer
  void act(const ActDef& def);

  /// All bodies that users hold, own user and others'; one entry for each spring, appended.
  void held_bodies(std::vector<HeldBody>& out) const;
  /// The local instance of a shared body; an invalid id if it is not shared.
  pbd::BodyId body_of(const SharedId& id) const;
  /// One state that combines all that is known of a body now, own and others', with the sum of
  /// their weights: see fuse() of summary.h. nullopt if it is not shared, or no state of it has a
  /// weight.
  std::optional<StateUpdate> fused(const SharedId& id) const;

  /// Receive packets and set this step's springs and estimates. `now`: session time of the world
  /// before the step, ns, above 0 (0 is reserved for "never").
  void before_step(SessionTime now);
  /// Record the step and send what is due. `now`: session time of the world after the step, ns.
  void after_step(SessionTime now);
  /// Announce that this peer leaves: the others drop its springs and states.
  void leave(SessionTime now);

  // For bodies that another engine steps. The world is then a view of them: before_step moves it
  // (with TwoStep or SingleOwner; the other couplings need the solver), the other engine takes over
  // the changes, applies these springs and steps, and poses and twists are copied back before
  // after_step.

  /// All users' springs, own and remote, as they pull during the step to come; appended. Anchors
  /// are those of its start and move on with their velocity.
  void springs(std::vector<pbd::Tether::Def>& out) const;
  /// Report that two bodies pushed each other in the step just made; an invalid id stands for any
  /// other object. Call it before after_step.
  void note_contact(pbd::BodyId a, pbd::BodyId b = {});

  const PeerStats& stats() const;
  /// Per peer, what was received and not believed, by ascending id; peers that left are kept. Valid
  /// until the next step.
  std::span<const PeerReport> reports() const;
  void set_observer(PeerObserver* observer);
  /// Must outlive the peer or be set to null. Called in each step of a replay.
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
