// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/session.h"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "roster.h"
#include "spawns.h"
#include "tandem/net/session.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

consensus::PeerOptions peer_options(const consensus::PeerOptions& given, bool no_clocks) {
  consensus::PeerOptions options = given;
  // Stamps of unsynchronised clocks are meaningless.
  if (no_clocks) options.timestamps = consensus::TimestampSource::Arrival;
  return options;
}

void require_name(std::string_view name) {
  if (name.empty()) pbd::detail::refuse("Session::share: name", "1 character or more", "empty");
}

/// Sets a flag for its lifetime.
class Running {
 public:
  explicit Running(bool& flag) : flag_(flag) { flag_ = true; }
  ~Running() { flag_ = false; }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

 private:
  bool& flag_;
};

pbd::World& without_peer(pbd::World& world) {
  if (world.target_source() != nullptr) {
    pbd::detail::refuse("Session: world", "one that no other peer or target source has", "taken");
  }
  return world;
}

}  // namespace

class __attribute__((visibility("hidden"))) Session::Impl {
 public:
  Impl(const Simulation& stepped, Wire through, const SessionOptions& options)
      : simulation(stepped),
        wire(std::move(through)),
        clock(options.clock ? options.clock : std::exchange(wire.clock, {})),
        pace(options.pace),
        events(*wire.transport, options.events),
        peer(without_peer(stepped.world), events, peer_options(options.peer, wire.no_clocks)) {
    pace.validate();
    options.spawning.validate();
    if (options.spawning.make) spawns.emplace(options.spawning, stepped.world, peer, events);
    if (!clock) clock = [own = net::SessionClock()]() mutable { return own.now(); };
  }
  ~Impl() {
    if (!physics) return;
    try {
      peer.leave(physics->physics_time());
    } catch (...) {  // from a custom transport: the peer leaves all the same
    }
  }

  /// Before a step: members that joined or left, and what the others have spawned.
  void hear(SessionTime now) {
    if (!spawns && !joined && !left) return;
    roster.look(events);
    if (spawns) {
      for (const PeerId id : roster.left()) spawns->leave(id);
      for (const PeerId id : roster.joined()) spawns->join(id);
    }
    // Copies, as a callback may set another one.
    const auto call = [](const std::function<void(PeerId)>& of, const std::vector<PeerId>& ids) {
      for (const PeerId id : ids) {
        if (of) of(id);
      }
    };
    call(std::function(left), roster.left());
    call(std::function(joined), roster.joined());
    if (spawns) spawns->receive(now);
  }
  Spawns& spawning() {
    if (!spawns)
      pbd::detail::refuse("SessionOptions: spawning.make", "set in order to spawn", "empty");
    return *spawns;
  }
  /// Session time at which the step to come begins, ns.
  SessionTime next_step() { return physics ? time : clock(); }

  Simulation simulation;
  Wire wire;
  ClockSource clock;
  net::PhysicsClockOptions pace;
  consensus::EventChannel events;
  consensus::Peer peer;  ///< must be destroyed before its transport
  std::optional<Spawns> spawns;
  Roster roster;
  std::function<void(PeerId)> joined;
  std::function<void(PeerId)> left;
  std::optional<net::PhysicsClock> physics;
  SessionTime time = 0;     ///< ns, of the step to come; valid with physics
  double world_time = 0.0;  ///< s, after the last step
  std::size_t shared = 0;
  bool running = false;   ///< in run()
  bool stepping = false;  ///< in advance()
  std::atomic<bool> stopped = false;
};

Session::Session(const Simulation& simulation, Wire wire, const SessionOptions& session)
    : impl_(std::make_unique<Impl>(simulation, std::move(wire), session)) {}
Session::~Session() = default;

void SpawnOptions::validate() const {
  if (static_cast<bool>(make) != static_cast<bool>(remove)) {
    pbd::detail::refuse("SpawnOptions: make and remove", "both set, or neither",
                        make ? "make alone" : "remove alone");
  }
  if (make && (max_bodies == 0 || max_of_one == 0)) {
    pbd::detail::refuse("SpawnOptions: max_bodies and max_of_one", "> 0", "0");
  }
}

SharedId Session::share(std::string_view name, pbd::BodyId body, std::optional<PeerId> owner) {
  require_name(name);
  const SharedId id = SharedId::from_name(name);
  try {
    impl_->peer.share({.id = id, .body = body, .owner = owner});
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("Session::share: \"" + std::string(name) + "\": " + error.what());
  }
  ++impl_->shared;
  return id;
}

void Session::share(std::string_view name, std::span<const pbd::BodyId> bodies,
                    std::optional<PeerId> owner) {
  require_name(name);
  std::vector<SharedId> done;
  try {
    for (const pbd::BodyId body : bodies) {
      done.push_back(share(std::string(name) + "/" + std::to_string(done.size()), body, owner));
    }
  } catch (...) {
    for (const SharedId& id : done) unshare(id);
    throw;
  }
}

void Session::unshare(const SharedId& id) {
  impl_->peer.unshare(id);
  if (impl_->shared > 0) --impl_->shared;
}

SharedId Session::spawn(std::string_view what, const pbd::Pose& pose, const pbd::Twist& twist) {
  return impl_->spawning().spawn(what, pose, twist, impl_->next_step());
}
void Session::despawn(const SharedId& id) { impl_->spawning().despawn(id); }
std::uint64_t Session::spawns_refused() const {
  return impl_->spawns ? impl_->spawns->refused() : 0;
}

void Session::on_join(std::function<void(PeerId)> joined) { impl_->joined = std::move(joined); }
void Session::on_leave(std::function<void(PeerId)> left) { impl_->left = std::move(left); }

GrabId Session::grab(const GrabDef& def) { return impl_->peer.grab(def); }
bool Session::move(GrabId grab, const pbd::Vec3& anchor_w) {
  const bool holds = impl_->peer.holds(grab);
  if (holds) impl_->peer.move(grab, anchor_w, impl_->next_step());
  return holds;
}
void Session::release(GrabId grab) {
  try {
    impl_->peer.release(grab);
  } catch (const std::invalid_argument&) {  // released already
  }
}

void Session::act(const ActDef& def) { impl_->peer.act(def); }

SessionTime Session::now() { return impl_->clock(); }

Progress Session::advance(SessionTime now, const BeforeStep& before_step) {
  Impl& own = *impl_;
  if (own.stepping) {
    pbd::detail::refuse("Session::advance", "called by none of the functions that it calls");
  }
  const Running stepping(own.stepping);
  Progress done;
  if (now < own.pace.nominal_step) {
    done.status = pbd::StepStatus::InvalidStep;
    return done;
  }
  const pbd::World& world = own.simulation.world;
  done.stepped_elsewhere = own.physics && world.time() != own.world_time;
  if (!own.physics) own.physics.emplace(own.pace, now);
  const net::ClockTick tick = own.physics->advance(now);
  done.skipped = tick.skipped;
  done.lag = tick.lag;
  done.held = tick.held;
  SessionTime& time = own.time;
  time = own.physics->physics_time();
  for (const std::int64_t step : tick.steps) time -= step;
  // Also if before_step throws: the steps made so far count, and the rest remains due.
  const struct Ending {
    Impl& own;
    ~Ending() {
      own.world_time = own.simulation.world.time();
      if (own.time < own.physics->physics_time()) own.physics.emplace(own.pace, own.time);
    }
  } ending{own};
  for (const std::int64_t step : tick.steps) {
    own.events.poll(time);
    own.hear(time);
    if (before_step) before_step(time);
    if (own.running && own.stopped) break;
    own.peer.before_step(time);
    const pbd::StepStatus status = own.simulation.step(net::seconds(step)).status;
    if (done.status == pbd::StepStatus::Ok) done.status = status;
    time += step;
    own.peer.after_step(time);
    ++done.steps;
  }
  return done;
}

void Session::run(const BeforeStep& before_step) {
  if (impl_->shared == 0 && !impl_->spawns && !before_step) {
    pbd::detail::refuse("Session::run: number of shared bodies",
                        "at least 1 where before_step shares none", "0");
  }
  const net::StopSignal signal;
  const Running while_here(impl_->running);
  // One stop() ends one run, even one that has not begun.
  const struct Heeded {
    std::atomic<bool>& stopped;
    ~Heeded() { stopped = false; }
  } heeded{impl_->stopped};
  if (!impl_->stopped) advance(now(), before_step);
  while (!impl_->stopped) {
    if (!impl_->physics) {
      pbd::detail::refuse("Session::run: session time", "a step of pace, in ns, or more",
                          static_cast<double>(now()));
    }
    const std::chrono::nanoseconds until_due(impl_->physics->next_due() - now());
    if (signal.wait(until_due)) break;
    advance(now(), before_step);
  }
}

void Session::stop() { impl_->stopped = true; }

consensus::EventChannel& Session::events() { return impl_->events; }
consensus::Peer& Session::peer() { return impl_->peer; }
consensus::Transport& Session::transport() { return *impl_->wire.transport; }

}  // namespace tandem
