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

/// What a session steps: a Scene (or whatever else has its world() and step()), or a world and its
/// solver. They outlive the session and stay where they are.
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

/// Bodies that members make for everybody while a session runs, see Session::spawn(). All members
/// have the same, or none.
struct TANDEM_API SpawnOptions {
  static constexpr std::size_t kMaxBytes = 512;  ///< of `what`

  /// Makes the body that `what` describes, which has come from another member (untrusted) or from
  /// spawn(). The session sets where it stands and how it moves. Where there is no such thing it
  /// returns BodyId{} or throws std::invalid_argument. Whatever else it throws comes out of
  /// advance(); that body is not made here, and the session goes on with the next one.
  std::function<pbd::BodyId(std::string_view what)> make = {};
  /// Takes a body out of the scene. It is shared no longer.
  std::function<void(pbd::BodyId)> remove = {};
  // Limits of spawn(), at a time. Others' bodies are taken up to twice as many, since members that
  // spawn at the same time do not know of each other's.
  std::size_t max_bodies = 1024;
  std::size_t max_of_one = 256;  ///< made by one member

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

struct TANDEM_API SessionOptions {
  /// 60 steps a second; PhysicsClockOptions::at_rate() for others.
  net::PhysicsClockOptions pace = {};
  consensus::PeerOptions peer = {};
  consensus::EventOptions events = {};
  SpawnOptions spawning = {};
  /// Session time now, ns. Empty: the transport's, where it has one as net::UdpTransport does, else
  /// that of a net::SessionClock.
  std::function<SessionTime()> clock = {};
};

/// What Session::advance() did.
struct TANDEM_API Progress {
  int steps = 0;
  /// Of the first step that was not Ok. InvalidStep: session time is below a step, and none was
  /// made.
  pbd::StepStatus status = pbd::StepStatus::Ok;
  std::int64_t skipped = 0;  ///< ns, as net::ClockTick has it
  std::int64_t lag = 0;      ///< ns that the world is behind, from 0 to a step in normal running
  std::int64_t held = 0;     ///< ns, as net::ClockTick has it: > 0 while nothing moves
  /// Something else than this session has stepped or restored the world since the last call: the
  /// other peers know nothing of it.
  bool stepped_elsewhere = false;
};

/// One participant of a session, with all that it runs on:
///
///     Session session(scene, net::TcpOptions{.self = 1, .listen_port = 7777, .session_key = key});
///     session.share("cube", cube);
///     session.run();  // or, within a loop of your own:  session.advance(session.now());
///
/// It makes steps of fixed length behind the session's clock. Its destructor tells the others that
/// it goes.
/// @par Thread safety  As consensus::Peer; stop() from any thread.
class TANDEM_API Session {
 public:
  /// Called before each step with session time, ns: to move hands, push, and read the events of the
  /// step before.
  using BeforeStep = std::function<void(SessionTime now)>;

  /// Over a transport of its own: net::TcpOptions, net::UdpOptions, or options of yours that name
  /// their `Transport`.
  /// @throws as that transport; std::invalid_argument where `session` is not valid or the world has
  ///   another peer
  template <class Options>
  requires requires { typename Options::Transport; }
  Session(const Simulation& simulation, const Options& transport,
          const SessionOptions& session = {})
      : Session(simulation, wire_of(transport), session) {}
  /// Over one that outlives it: a virtual network's, or yours. @throws likewise
  template <std::derived_from<consensus::Transport> Transport>
  Session(const Simulation& simulation, Transport& transport, const SessionOptions& session = {})
      : Session(simulation, Wire{nullptr, &transport, clock_of(transport), false}, session) {}
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Share a body with all peers that share one by the same name.
  /// @param owner  whose hand moves it, where it is nobody's but theirs
  /// @return what consensus::Peer knows it by
  /// @throws std::invalid_argument naming the name, and what is wrong: name or body is shared
  ///   already, or the body is none that can move
  SharedId share(std::string_view name, pbd::BodyId body, std::optional<PeerId> owner = {});
  /// Share all bodies of one thing, as Ragdoll::bodies(), as "name/0", "name/1" and so on, or none
  /// of them. @throws likewise
  void share(std::string_view name, std::span<const pbd::BodyId> bodies,
             std::optional<PeerId> owner = {});
  /// @throws as consensus::Peer::unshare
  void unshare(const SharedId& id);

  /// Make a body at every member, the later ones included, and share it.
  /// @param what  what SpawnOptions::make is given, at every member
  /// @param pose  of the centre of mass
  /// @throws std::invalid_argument where there is no such thing, no place for one more, or `what`
  ///   is longer than SpawnOptions::kMaxBytes; what `make` throws. Nothing is made then
  SharedId spawn(std::string_view what, const pbd::Pose& pose, const pbd::Twist& twist = {});
  /// Remove a body at every member that any of them has spawned.
  /// @throws std::invalid_argument where no member has spawned it, or one has removed it
  void despawn(const SharedId& id);
  /// Requests of other members to spawn or despawn that this one refused.
  std::uint64_t spawns_refused() const;

  /// Before each step, and its BeforeStep, `joined` is called once for each member that has
  /// connected since the last one, `left` for each that is connected no longer. A member that
  /// starts again at once may go unnoticed.
  void on_join(std::function<void(PeerId)> joined);
  void on_leave(std::function<void(PeerId)> left);

  /// Hold a shared body with a spring. @throws as consensus::Peer::grab
  GrabId grab(const GrabDef& def);
  /// Where the hand is as the next step begins, m, world.
  /// @return whether the spring still holds: not after release(), nor once the body is removed
  bool move(GrabId grab, const pbd::Vec3& anchor_w);
  /// Let go, if it still holds.
  void release(GrabId grab);

  /// Kick, blast or put somewhere a shared body, here and at all members. @throws as
  /// consensus::Peer::act
  void act(const ActDef& def);

  /// Session time, ns.
  SessionTime now();
  /// Make the steps that are due at `now`, and only those: it waits for nothing. The first call
  /// begins. Throws what functions and transports of yours do, and std::invalid_argument where one
  /// of them calls it.
  Progress advance(SessionTime now, const BeforeStep& before_step = {});
  /// Go on at the clock's pace until stop(), SIGINT or SIGTERM (net::StopSignal, one at a time).
  /// @throws std::invalid_argument where nothing is shared and nothing is called that could share
  void run(const BeforeStep& before_step = {});
  /// Ends run(), or the next one; from within `before_step`, before that step.
  void stop();

  /// Messages of the application; topics that begin with "tandem." are the session's. What has come
  /// is there from before each step on, and gone with the next: read it in `before_step`.
  consensus::EventChannel& events();

  // The parts.
  consensus::Peer& peer();
  consensus::Transport& transport();

 private:
  class Impl;
  using ClockSource = std::function<SessionTime()>;
  struct Wire {
    std::unique_ptr<consensus::Transport> own;  ///< null where it is another's
    consensus::Transport* transport = nullptr;
    ClockSource clock;       ///< empty where the transport has none
    bool no_clocks = false;  ///< peers' clocks have nothing to do with each other
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
