// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/peer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "agree/agreement.h"
#include "agree/settlement.h"
#include "couple/ownership.h"
#include "couple/two_step.h"
#include "input/activity.h"
#include "members/connections.h"
#include "peer_data.h"
#include "receive/receiver.h"
#include "replay/replay.h"
#include "send/sender.h"
#include "tandem/consensus/summary.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

/// The stages of one peer, in the order of docs/ARCHITECTURE.md. Each is in its own file; the
/// functions below call them in order.
class __attribute__((visibility("hidden"))) Peer::Impl {
 public:
  Impl(pbd::World& world, Transport& transport, const PeerOptions& options);

  PeerData data;
  Connections connections;
  std::unique_ptr<Replay> replay;  ///< null: a predictor extrapolates all states to now
  Trust trust;
  Latecomers latecomers;
  Activity activity;
  Receiver receiver;
  Ownership ownership;
  RemoteStates remote;
  Placement placement;
  Settlement settlement;
  Estimator estimator;
  HardInputs hard;
  Agreement agreement;
  Sender sender;
  const bool settles;           ///< whether disagreeing copies at rest elect one
  SessionTime last_before = 0;  ///< ns, of the last before_step()
};

namespace {

/// s: no application steps so slowly.
constexpr double kLongestStep = 0.5;

std::unique_ptr<Replay> replay_of(const PeerData& data) {
  const PeerOptions& options = data.options;
  // The other couplings use forces, or an owner's state, and average nothing.
  const bool averaged =
      options.coupling == Coupling::OnePass || options.coupling == Coupling::TwoStep;
  const bool replays =
      options.predictor == PredictorKind::Replay && options.own_predictor == nullptr;
  if (!averaged || !replays) return nullptr;
  return std::make_unique<Replay>(data.world, data.history, data.springs, options.replay);
}

/// Set the time of a step, and drop what belongs to other times.
void begin_step(PeerData& data, Sender& sender, SessionTime last, SessionTime now) {
  data.now = now;
  data.step_dt = last > 0 ? seconds(now - last) : 1.0 / 60.0;
  if (data.step_dt < 0.0) {  // clock set back: nothing moves, and no peer counts as silent
    data.step_dt = 0.0;
    sender.restart();
    // Else this peer's states would be ignored for as long as its clock was ahead.
    data.started = std::min(data.started, now);
  }
  // The clock was set, or nothing was stepped for a long time.
  if (now < last || data.step_dt > kLongestStep) data.history.clear();
  // Bodies added since are recorded from now on.
  if (data.history.empty()) data.history.add(now, data.world);
  data.history.notice(data.world);
}

/// For couplings outside of the pass: apply the targets before a plain step.
void average_before_step(PeerData& data, const Agreement& agreement) {
  const PeerOptions& options = data.options;
  const bool thresholds = options.coupling == Coupling::TwoStep && options.two_step_thresholds;
  for (std::size_t i = 0; i < agreement.targets().size(); ++i) {
    const pbd::PoseTarget& target = agreement.targets()[i];
    SharedBody& shared = *agreement.targeted()[i];
    if (!thresholds && rests(data.world, target, data.step_dt, shared.still)) continue;
    shared.averaged = average_state(data.world, target, data.step_dt, options.two_step_thresholds);
    data.history.note_agreement(target.body.index, data.world);
  }
}

}  // namespace

using pbd::detail::require;
using pbd::detail::require_in;

void SendOptions::validate() const {
  require(kbit_per_s == 0.0 || (kbit_per_s >= 8.0 && kbit_per_s <= 1e9), "SendOptions",
          "kbit_per_s", kbit_per_s, "0 or from 8 to 1e9");
  require_in(0.0, 1e3, "SendOptions", "tolerance", tolerance, "m");
  require(angle_tolerance > 0.0 && angle_tolerance <= 10.0, "SendOptions", "angle_tolerance",
          angle_tolerance, "above 0 and at most 10 rad");
  require_in(0.0, 3600.0, "SendOptions", "refresh", refresh, "s");
  require_in(0.0, 3600.0, "SendOptions", "rest_refresh", rest_refresh, "s");
}

void PeerOptions::validate() const {
  influence.validate();
  sending.validate();
  prediction.validate();
  replay.validate();
  robust.validate();
  plausibility.validate();
  require_in(1e-3, 1e4, "PeerOptions", "update_hz", update_hz);
  require(authority_ramp >= 0.0 && std::isfinite(authority_ramp), "PeerOptions", "authority_ramp",
          authority_ramp, "finite and >= 0 s");
  // Times are 64-bit nanoseconds: a day is as good as infinity, and fits.
  constexpr double kLongest = 86400.0;
  require_in(0.0, kLongest, "PeerOptions", "max_future", max_future, "s");
  require(spring_timeout > 0.0 && spring_timeout <= kLongest, "PeerOptions", "spring_timeout",
          spring_timeout, "above 0 and at most 86400 s");
  require_in(0.0, kLongest, "PeerOptions", "max_anchor_extrapolation", max_anchor_extrapolation,
             "s");
}

Peer::Impl::Impl(pbd::World& world, Transport& transport, const PeerOptions& options)
    : data(world, transport, options),
      connections(transport, data.stats),
      replay(replay_of(data)),
      trust(data),
      latecomers(data),
      activity(data, trust, latecomers),
      receiver(data, connections),
      ownership(data, connections, activity),
      remote(data),
      placement(data),
      settlement(data, trust, latecomers, activity, placement),
      estimator(data, trust, remote, placement),
      hard(data),
      agreement(data, replay.get(), trust, latecomers, estimator, hard),
      sender(data, connections, activity),
      settles(options.arbitration &&
              (options.coupling == Coupling::OnePass || options.coupling == Coupling::TwoStep)) {}

Peer::Peer(pbd::World& world, Transport& transport, const PeerOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(world, transport, options);
  world.set_target_source(this);
}

Peer::~Peer() {
  // The world must not call a destroyed target source.
  pbd::World& world = impl_->data.world;
  if (world.target_source() == this) world.set_target_source(nullptr);
}

void Peer::before_step(SessionTime now) {
  begin_step(impl_->data, impl_->sender, std::exchange(impl_->last_before, now), now);
  impl_->data.acts.prepare(now);
  impl_->receiver.receive();
  for (const PeerId peer : impl_->receiver.wants_all()) impl_->sender.tell_again(peer);
  impl_->data.springs.prepare(now, impl_->data.step_dt);
  if (impl_->data.options.coupling == Coupling::SingleOwner) {
    impl_->ownership.update(impl_->receiver.ownership());
  }
  if (impl_->settles && impl_->data.world.contacts() != nullptr) impl_->settlement.settle();
  impl_->agreement.aggregate();
  if (!impl_->data.in_pass()) average_before_step(impl_->data, impl_->agreement);
}

void Peer::after_step(SessionTime now) {
  PeerData& data = impl_->data;
  data.now = now;
  if (data.started == 0) data.started = now;
  const double dt = seconds(now - impl_->last_before);
  impl_->activity.look();
  for (std::size_t i = 0; i < data.bodies.size(); ++i) {
    SharedBody& shared = data.bodies[i];
    if (!data.world.contains(shared.def.body)) continue;
    impl_->hard.carry_on(shared, dt);
    impl_->placement.note_step(shared, dt);
    impl_->activity.look_at(shared, data.inbox.newest_at(i));
  }
  data.history.add(now, data.world);
  if (impl_->replay != nullptr) impl_->replay->keep();
  impl_->sender.send();
}

void Peer::collect(const pbd::World& /*world*/, double /*dt*/, const pbd::SolverOptions& options,
                   std::vector<pbd::PoseTarget>& out) {
  PeerData& data = impl_->data;
  if (impl_->replay != nullptr) {
    impl_->replay->set_solver(options);
    // Nothing is recorded if the world is stepped before before_step().
    if (!data.history.empty()) {
      data.history.note_inputs(data.world);
      data.springs.record(data.history.pulls());
    }
  }
  const auto targets = impl_->agreement.targets();
  if (data.in_pass()) out.insert(out.end(), targets.begin(), targets.end());
}

void Peer::leave(SessionTime now) {
  impl_->connections.refresh();
  impl_->connections.post(Connections::kToAll, Leave{.stamp = now}, Delivery::Reliable);
}

void Peer::share(const ShareDef& def) {
  impl_->data.bodies.add(def, impl_->sender.most_bodies());
  impl_->data.inbox.add_id(def.id);
  impl_->agreement.clear();  // its targets point into the old bodies
}

void Peer::set_owner(const SharedId& id, std::optional<PeerId> owner) {
  SharedBodies& bodies = impl_->data.bodies;
  bodies.set_owner(bodies.at(id), owner);
}

void Peer::unshare(const SharedId& id) {
  PeerData& data = impl_->data;
  SharedBody& shared = data.bodies.at(id);
  data.springs.forget_body(shared.def.body, data.now);
  data.acts.forget_body(shared.def.body);
  data.inbox.remove_id(id);
  data.bodies.remove(shared);
  impl_->agreement.clear();
}

std::optional<PeerId> Peer::owner(const SharedId& id) const {
  const SharedBody& shared = impl_->data.bodies.at(id);
  if (!impl_->data.changes_hands(shared)) return shared.def.owner;
  const PeerId owner = shared.tenure.owner;
  return owner != 0 ? std::optional(owner) : std::nullopt;
}

std::optional<SessionTime> Peer::heard(const SharedId& id, PeerId from) const {
  const Inbox& inbox = impl_->data.inbox;
  for (const Inbox::Received& received : inbox.newest(id)) {
    if (received.peer == from) return inbox.holds_until(received);
  }
  return std::nullopt;
}

void Peer::held_bodies(std::vector<HeldBody>& out) const {
  impl_->data.springs.held(impl_->data.self(), out);
}

pbd::BodyId Peer::body_of(const SharedId& id) const {
  const SharedBody* const shared = impl_->data.bodies.find(id);
  return shared != nullptr ? shared->def.body : pbd::BodyId{};
}

std::optional<StateUpdate> Peer::fused(const SharedId& id) const {
  PeerData& data = impl_->data;
  const SharedBody* const shared = data.bodies.find(id);
  if (shared == nullptr || !data.world.contains(shared->def.body)) return std::nullopt;
  const pbd::BodyState& own = data.world.state(shared->def.body);
  std::vector<StateUpdate> states;
  states.push_back({.id = id,
                    .pose = own.pose,
                    .twist = own.twist,
                    .influence = static_cast<float>(data.announced(*shared)),
                    .stamp = data.now,
                    .flags = {.in_contact = shared->coupled && !shared->held,
                              .held = shared->held,
                              .leads = shared->initiative.strength() >= 1.0},
                    .oriented = shared->def.orientation});
  impl_->remote.as_of_now(*shared, data.inbox.newest(id), states);
  return fuse(states);
}

bool Peer::held(const SharedId& id) const {
  const SharedBody* const shared = impl_->data.bodies.find(id);
  return shared != nullptr && impl_->data.springs.holds(shared->def.body);
}

GrabId Peer::grab(const GrabDef& def) {
  return impl_->data.springs.grab(def, impl_->data.bodies.at(def.body).def.body);
}

void Peer::move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now) {
  impl_->data.springs.move(id, anchor_w, now);
}

void Peer::act(const ActDef& def) {
  PeerData& data = impl_->data;
  SharedBody& shared = data.bodies.at(def.body);
  const pbd::BodyId body = shared.def.body;
  pbd::detail::require_body(data.world, body, "ActDef", "body");
  if (data.world.props(body).type != pbd::BodyType::Dynamic) {
    pbd::detail::refuse("ActDef: body", "a dynamic one", def.body.to_string());
  }
  const std::optional<PeerId> owned_by = owner(def.body);
  if (owned_by.has_value() && *owned_by != data.self()) {
    pbd::detail::refuse("ActDef: body", "nobody's or this peer's",
                        "peer " + std::to_string(*owned_by) + "'s");
  }
  const CodecResult result = check(as_update(def));
  if (!result.ok()) throw std::invalid_argument(std::string("ActDef: ") + result.detail);
  const bool owned = owned_by.has_value();
  if (!data.acts.act(def, shared, data.self(), owned, data.now)) ++data.stats.acts_refused;
}

const PeerStats& Peer::stats() const {
  impl_->data.stats.inbox = impl_->data.inbox.totals();
  return impl_->data.stats;
}

std::span<const PeerReport> Peer::reports() const {
  PeerData& data = impl_->data;
  for (PeerReport& report : data.reports) report.inbox = data.inbox.counters(report.peer);
  return data.reports;
}

void Peer::set_replay_hook(ReplayHook* hook) {
  if (impl_->replay != nullptr) impl_->replay->set_hook(hook);
}

bool Peer::holds(GrabId id) const { return impl_->data.springs.holds(id); }

void Peer::release(GrabId id) { impl_->data.springs.release(id, impl_->data.now); }
void Peer::springs(std::vector<pbd::Tether::Def>& out) const { impl_->data.springs.pulls(out); }
void Peer::note_contact(pbd::BodyId a, pbd::BodyId b) { impl_->activity.note_contact(a, b); }
std::span<const UnknownState> Peer::unknown() const { return impl_->receiver.unknown(); }
void Peer::set_observer(PeerObserver* observer) { impl_->remote.set_observer(observer); }
void Peer::set_interest(const Interest* interest) { impl_->sender.set_interest(interest); }

}  // namespace tandem::consensus
