// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "tandem/consensus/events.h"
#include "tandem/consensus/peer.h"
#include "tandem/net/clock.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/solver.h"

namespace tandem {

using consensus::ActDef;
using consensus::GrabDef;
using consensus::GrabId;
using consensus::PeerId;
using consensus::SessionTime;
using consensus::SharedId;

/// The simulation that a session steps: a Scene (or any type with its world() and step()), or a
/// world and its solver. They must outlive the session and not be moved.
struct TANDEM_API Simulation {
  template <class Scene>
  requires requires(Scene& scene) {
    { scene.world() } -> std::same_as<pbd::World&>;
    { scene.step(0.0) } -> std::same_as<const pbd::StepReport&>;
  }
  Simulation(Scene& scene)  // NOLINT(google-explicit-constructor): a view of it
      : world(scene.world()),
        step([&scene](double dt) -> const pbd::StepReport& { return scene.step(dt); }) {}
  Simulation(pbd::World& stepped, pbd::Solver& solver)
      : world(stepped),
        step([&](double dt) -> const pbd::StepReport& { return solver.step(stepped, dt); }) {}

  pbd::World& world;
  std::function<const pbd::StepReport&(double)> step;
};

/// Bodies that members spawn for all members during a session, see Session::spawn(). All members
/// have these options, or none.
struct TANDEM_API SpawnOptions {
  static constexpr std::size_t kMaxBytes = 512;  ///< of `what`

  /// Makes the body that `what` describes, which comes from another member (untrusted) or from
  /// spawn(). The session sets its pose and twist. For an unknown `what` it returns BodyId{} or
  /// throws std::invalid_argument. Any other exception leaves advance(); that body is not made
  /// here, and the session continues with the next one.
  std::function<pbd::BodyId(std::string_view what)> make = {};
  /// Removes a body from the scene; it is no longer shared.
  std::function<void(pbd::BodyId)> remove = {};
  // Limits of spawn(), for bodies alive at one time. Others' bodies are accepted up to twice as
  // many, since members that spawn at the same time do not know of each other's.
  std::size_t max_bodies = 1024;
  std::size_t max_of_one = 256;  ///< per member

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

struct TANDEM_API SessionOptions {
  /// 60 steps a second; for other rates see PhysicsClockOptions::at_rate().
  net::PhysicsClockOptions pace = {};
  consensus::PeerOptions peer = {};
  consensus::EventOptions events = {};
  SpawnOptions spawning = {};
  /// Session time now, ns. Empty: the transport's, if it has one like net::UdpTransport, else a
  /// net::SessionClock.
  std::function<SessionTime()> clock = {};
};

/// Result of Session::advance().
struct TANDEM_API Progress {
  int steps = 0;
  /// Status of the first step that was not Ok. InvalidStep: session time is less than a step, and
  /// none was made.
  pbd::StepStatus status = pbd::StepStatus::Ok;
  std::int64_t skipped = 0;  ///< ns, as in net::ClockTick
  std::int64_t lag = 0;      ///< ns that the world is behind, from 0 to a step in normal operation
  std::int64_t held = 0;     ///< ns, as in net::ClockTick: > 0 while nothing moves
  /// The world was stepped or restored by other code since the last call: the other peers do not
  /// know.
  bool stepped_elsewhere = false;
};

/// One participant of a session, with all its parts:
///
///     Session session(scene, net::TcpOptions{.self = 1, .listen_port = 7777, .session_key = key});
///     session.share("cube", cube);
///     session.run();  // or, within a loop of your own:  session.advance(session.now());
///
/// It makes steps of fixed length behind the session's clock. Its destructor announces that it
/// leaves.
/// @par Thread safety  As consensus::Peer; stop() from any thread.
class TANDEM_API Session {
 public:
  /// Called before each step with session time, ns: to move hands, apply impulses, and read the
  /// events of the step before.
  using BeforeStep = std::function<void(SessionTime now)>;

  /// With its own transport: net::TcpOptions, net::UdpOptions, or custom options that name their
  /// `Transport`.
  /// @throws as as that transport; std::invalid_argument if `session` is not valid or the world has
  /// another peer
  template <class Options>
  requires requires { typename Options::Transport; }
  Session(const Simulation& simulation, const Options& transport,
          const SessionOptions& session = {})
      : Session(simulation, wire_of(transport), session) {}
  /// With a transport that outlives it: a virtual network's, or a custom one. @throws as above
  template <std::derived_from<consensus::Transport> Transport>
  Session(const Simulation& simulation, Transport& transport, const SessionOptions& session = {})
      : Session(simulation, Wire{nullptr, &transport, clock_of(transport), false}, session) {}
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Share a body with all peers that share one under the same name.
  /// @param owner  peer whose hand alone moves it
  /// @return its id for consensus::Peer
  /// @throws std::invalid_argument naming the name and the fault: name or body is shared already,
  /// or the body cannot move
  SharedId share(std::string_view name, pbd::BodyId body, std::optional<PeerId> owner = {});
  /// Share all bodies of one object, such as Ragdoll::bodies(), as "name/0", "name/1" and so on, or
  /// none of them. @throws as share
  void share(std::string_view name, std::span<const pbd::BodyId> bodies,
             std::optional<PeerId> owner = {});
  /// @throws as consensus::Peer::unshare
  void unshare(const SharedId& id);

  /// Make a body at every member, later ones included, and share it.
  /// @param what  argument of SpawnOptions::make at every member
  /// @param pose  of the centre of mass
  /// @throws std::invalid_argument if `what` is unknown or longer than SpawnOptions::kMaxBytes, or
  /// the limits are exhausted; what `make` throws. Nothing is made then
  SharedId spawn(std::string_view what, const pbd::Pose& pose, const pbd::Twist& twist = {});
  /// Remove a body that any member has spawned, at every member.
  /// @throws std::invalid_argument if no member has spawned it, or one has removed it
  void despawn(const SharedId& id);
  /// Other members' requests to spawn or despawn that this one refused.
  std::uint64_t spawns_refused() const;

  /// Before each step, and before its BeforeStep, `joined` is called once for each newly connected
  /// member, and `left` for each that is no longer connected. A member that restarts quickly may go
  /// unnoticed.
  void on_join(std::function<void(PeerId)> joined);
  void on_leave(std::function<void(PeerId)> left);

  /// Hold a shared body with a spring. @throws as consensus::Peer::grab
  GrabId grab(const GrabDef& def);
  /// Position of the hand when the next step begins, m, world.
  /// @return whether the spring still holds: not after release(), nor once the body is removed
  bool move(GrabId grab, const pbd::Vec3& anchor_w);
  /// Release the spring, if it still holds.
  void release(GrabId grab);

  /// Apply an impulse to a shared body or place it, here and at all members. @throws as
  /// consensus::Peer::act
  void act(const ActDef& def);

  /// Session time, ns.
  SessionTime now();
  /// Make the steps that are due at `now`, and only those: it never blocks. The first call begins.
  /// Throws what callbacks and custom transports throw, and std::invalid_argument if one of them
  /// calls it.
  Progress advance(SessionTime now, const BeforeStep& before_step = {});
  /// Run at the clock's pace until stop(), SIGINT or SIGTERM (net::StopSignal, one at a time).
  /// @throws std::invalid_argument if nothing is shared and there is no callback that could share
  void run(const BeforeStep& before_step = {});
  /// Ends run(), or the next one; called in `before_step`, before that step.
  void stop();

  /// Messages of the application; topics that begin with "tandem." are reserved. Received events
  /// are available from the start of a step to the next: read them in `before_step`.
  consensus::EventChannel& events();

  // The parts.
  consensus::Peer& peer();
  consensus::Transport& transport();

 private:
  class Impl;
  using ClockSource = std::function<SessionTime()>;
  struct Wire {
    std::unique_ptr<consensus::Transport> own;  ///< null if the caller owns it
    consensus::Transport* transport = nullptr;
    ClockSource clock;       ///< empty if the transport has none
    bool no_clocks = false;  ///< peers' clocks are unrelated
  };

  template <class Transport>
  static ClockSource clock_of(const Transport& transport) {
    if constexpr (requires { transport.session_now(); }) {
      return [&transport] { return transport.session_now(); };
    }
    return {};
  }
  template <class Options>
  static Wire wire_of(const Options& options) {
    auto own = std::make_unique<typename Options::Transport>(options);
    Wire wire{nullptr, own.get(), clock_of(*own), false};
    if constexpr (requires { options.clock; }) wire.no_clocks = options.clock == net::Clock::None;
    wire.own = std::move(own);
    return wire;
  }
  Session(const Simulation& simulation, Wire wire, const SessionOptions& session);

  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
