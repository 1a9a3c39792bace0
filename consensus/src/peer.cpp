// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/peer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cpu_clock.h"
#include "springs.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

constexpr double kNs = 1e-9;

/// ns: a farewell ends what is stamped up to this long from now, see InboxOptions::max_future.
constexpr SessionTime kMaxAhead = 1'000'000'000;

/// A peer that does not own a body is heard with no more than this, whatever it claims.
constexpr double kMaxSharedInfluence = 0.5;

/// Orientations further apart than this (rad) have no useful average: two peers that pull a cube
/// onto different faces would hold it on its edge for ever. Then the lower id leads and the higher
/// follows; goes over from the first to the second.
constexpr double kLeadFromAngle = 0.6;
constexpr double kLeadToAngle = 1.2;
/// A follower that neighbours keep from turning pulls harder with time, so that a body wedged in
/// different ways is set right after some two seconds instead of never.
constexpr double kLeadGrowth = 6.0;  // 1/s^2

// Two-step coupling leaves smaller differences alone, [friston] Sec. 4.6.
constexpr double kTwoStepPosition = 1e-3;                         // m
constexpr double kTwoStepVelocity = 1e-2;                         // m/s
constexpr double kTwoStepAngle = 3.14159265358979323846 / 180.0;  // rad

void require(bool ok, const char* field, double value, const char* rule) {
  if (ok) return;
  throw std::invalid_argument(std::string("PeerOptions: ") + field + " = " + std::to_string(value) +
                              " breaks the rule: " + rule);
}

/// Marks bodies that a joint (not a contact, not a user's spring) holds to another.
class JointMarker final : public pbd::LinkVisitor {
 public:
  explicit JointMarker(std::vector<std::uint8_t>& marks) : marks_(marks) {}
  void link(std::uint32_t a, std::uint32_t b) override {
    if (a == pbd::BodyId::kNone || b == pbd::BodyId::kNone) return;
    marks_[a] = 1;
    marks_[b] = 1;
  }

 private:
  std::vector<std::uint8_t>& marks_;
};

}  // namespace

void PeerOptions::validate() const {
  influence.validate();
  require(update_hz > 0.0 && update_hz <= 10000.0, "update_hz", update_hz, "above 0 to 10000");
  require(authority_ramp >= 0.0 && std::isfinite(authority_ramp), "authority_ramp", authority_ramp,
          "finite and >= 0 s");
  require(spring_timeout > 0.0 && std::isfinite(spring_timeout), "spring_timeout", spring_timeout,
          "finite and > 0 s");
  require(max_anchor_extrapolation >= 0.0 && std::isfinite(max_anchor_extrapolation),
          "max_anchor_extrapolation", max_anchor_extrapolation, "finite and >= 0 s");
  require(anchor_velocity_filter > 0.0 && std::isfinite(anchor_velocity_filter),
          "anchor_velocity_filter", anchor_velocity_filter, "finite and > 0 s");
}

class Peer::Impl {
 public:
  Impl(pbd::World& world, Transport& transport, const PeerOptions& options)
      : options_(options),
        world_(world),
        transport_(transport),
        springs_(world, options_),
        inbox_({.max_age = options.influence.max_age}),
        predictor_(options.predictor == PredictorKind::Euler ? make_euler_predictor()
                                                             : make_local_motion_predictor()) {}

  void share(const ShareDef& def) {
    if (!def.id.valid()) throw std::invalid_argument("ShareDef: id = 0 breaks the rule: not zero");
    pbd::detail::require_body(world_, def.body, "ShareDef", "body");
    if (find(def.id) != nullptr) {
      throw std::invalid_argument("ShareDef: id = " + def.id.to_string() +
                                  " breaks the rule: shared once only");
    }
    const auto at =
        std::lower_bound(shared_.begin(), shared_.end(), def.id,
                         [](const Shared& s, const SharedId& id) { return s.def.id < id; });
    shared_.insert(at, Shared{.def = def});
    inbox_.add_id(def.id);
  }

  void set_owner(const SharedId& id, std::optional<PeerId> owner) { at(id).def.owner = owner; }

  GrabId grab(const GrabDef& def) { return springs_.grab(def, at(def.body).def.body); }
  Springs& springs() { return springs_; }
  bool held(const SharedId& id) const {
    const Shared* shared = const_cast<Impl*>(this)->find(id);
    return shared != nullptr && springs_.holds(shared->def.body);
  }

  void before_step(SessionTime now) {
    step_dt_ = last_before_ > 0 ? kNs * static_cast<double>(now - last_before_) : 1.0 / 60.0;
    last_before_ = now;
    now_ = now;
    for (Shared& shared : shared_) {
      // An instance that nothing has moved yet is known from now on.
      if (shared.history.empty()) remember(shared, now, {});
    }
    receive(now);
    springs_.prepare(now);
    aggregate(now);
    if (options_.coupling == Coupling::TwoStep) average_states();
  }

  void after_step(SessionTime now) {
    now_ = now;
    if (started_ == 0) started_ = now;
    mark_joints();
    for (Shared& shared : shared_) {
      if (!world_.contains(shared.def.body)) continue;
      remember(shared, now,
               options_.coupling == Coupling::OnePass ? world_.correction(shared.def.body)
                                                      : shared.averaged);
      shared.averaged = {};
    }
    if (now >= next_send_) {
      const auto interval = static_cast<SessionTime>(1.0 / (kNs * options_.update_hz));
      next_send_ = std::max(next_send_ + interval, now - interval);
      send(now);
    }
  }

  void leave(SessionTime now) {
    outgoing_.clear();
    encode(Leave{.stamp = now}, outgoing_);
    post_all(Delivery::Reliable);
  }

  void collect(std::vector<pbd::PoseTarget>& out) const {
    if (options_.coupling == Coupling::OnePass) {
      out.insert(out.end(), targets_.begin(), targets_.end());
    }
  }

  /// The world must not ask a peer that is gone for targets.
  void release_world(const Peer* peer) {
    if (world_.target_source() == peer) world_.set_target_source(nullptr);
  }

  const PeerStats& stats() {
    stats_.inbox = inbox_.totals();
    return stats_;
  }
  SessionTime now() const { return now_; }
  void set_observer(PeerObserver* observer) { observer_ = observer; }

 private:
  struct Shared {
    ShareDef def;
    MotionHistory history = {};
    pbd::Correction averaged = {};  ///< by two-step coupling, this step
    bool held = false;
    SessionTime following_since = 0;  ///< when the leader's orientation was last close; 0 = never
  };

  Shared* find(const SharedId& id) {
    const auto it =
        std::lower_bound(shared_.begin(), shared_.end(), id,
                         [](const Shared& s, const SharedId& i) { return s.def.id < i; });
    return it != shared_.end() && it->def.id == id ? &*it : nullptr;
  }
  Shared& at(const SharedId& id) {
    Shared* shared = find(id);
    if (shared == nullptr) {
      throw std::invalid_argument("Peer: id = " + id.to_string() + " breaks the rule: shared here");
    }
    return *shared;
  }

  // --- receive ----------------------------------------------------------------------------------

  void receive(SessionTime now) {
    packets_.clear();
    transport_.drain(packets_);
    for (const Packet& packet : packets_) {
      if (packet.from == 0) continue;  // no peer has this id
      ++stats_.packets_received;
      const CpuTimer parse(stats_.parse_s);
      const CodecResult result = decode(packet.bytes, incoming_);
      if (!result.ok()) {
        ++stats_.packets_rejected;
        transport_.drop(packet.from, "undecodable packet: " + result.reason());
        continue;
      }
      stats_.updates_received += incoming_.states.size();
      const CpuTimer process(stats_.process_s);
      take_in(packet.from, now);
    }
  }

  void take_in(PeerId from, SessionTime now) {
    inbox_.add_peer(from);
    const SessionTime farewell = farewell_of(from);
    for (const StateUpdate& update : incoming_.states) {
      // Overtaken by the farewell; what is stamped later comes from a successor.
      if (update.stamp <= farewell) continue;
      if (inbox_.offer(from, update, now) == InboxVerdict::UnknownId) ++stats_.unknown_ids;
    }
    for (const SpringUpdate& update : incoming_.springs) {
      const Shared* shared = find(update.body);
      if (shared == nullptr || !world_.contains(shared->def.body)) {
        ++stats_.springs_refused;
        continue;
      }
      if (!springs_.receive(from, update, shared->def.body, now)) ++stats_.springs_refused;
    }
    if (!incoming_.leaves.empty()) {
      inbox_.remove_peer(from);
      std::erase_if(farewells_, [from](const auto& entry) { return entry.first == from; });
      // Peers' steps are some way ahead of each other's; a stamp far ahead must not bar a
      // successor.
      farewells_.emplace_back(from, std::min(now + kMaxAhead, incoming_.leaves.back().stamp));
      springs_.drop_peer(from, now);
    }
  }

  /// Stamp of a peer's farewell; the beginning of time where it has not left.
  SessionTime farewell_of(PeerId peer) const {
    for (const auto& [id, stamp] : farewells_) {
      if (id == peer) return stamp;
    }
    return std::numeric_limits<SessionTime>::min();
  }

  // --- predict and fuse -------------------------------------------------------------------------

  void aggregate(SessionTime now) {
    const CpuTimer timer(stats_.aggregate_s);
    targets_.clear();
    for (Shared& shared : shared_) {
      if (!world_.contains(shared.def.body)) continue;
      if (shared.def.owner == transport_.self()) continue;
      estimate(shared, now);
      if (estimates_.empty()) continue;
      ++stats_.bodies_aggregated;
      pbd::PoseTarget& target = targets_.emplace_back();
      target.body = shared.def.body;
      target.motion = motion_;
      if (!fuse(world_.pose(shared.def.body), estimates_, target)) targets_.pop_back();
    }
  }

  /// Every peer's newest state of one body, carried to now.
  void estimate(Shared& shared, SessionTime now) {
    estimates_.clear();
    const auto newest = inbox_.newest(shared.def.id);
    const pbd::BodyState& own = world_.state(shared.def.body);
    const double own_announced = announced(shared);
    for (const Inbox::Received& received : newest) {
      const bool owner = shared.def.owner == received.peer;
      if (shared.def.owner.has_value() && !owner) continue;
      const double age = kNs * static_cast<double>(now - received.update.stamp);
      const double claimed = static_cast<double>(received.update.influence);
      const double heard = owner ? 1.0 : std::min(claimed, kMaxSharedInfluence);
      double share = effective_share(options_.influence, heard, age, predictor_->gain());
      if (!owner) share = against_own(lead(shared, received, now, share));
      if (!(share > 0.0)) continue;
      const double mirrored =
          effective_share(options_.influence, own_announced, age, predictor_->gain());
      const Prediction prediction = predictor_->predict(received.update, shared.history,
                                                        {.now = now,
                                                         .mirrored_share = mirrored / share,
                                                         .peers = static_cast<int>(newest.size())});
      const pbd::Vec3 position = own.pose.position + prediction.translation;
      estimates_.push_back(
          {.peer = received.peer,
           .pose = {position, pbd::rotated(own.pose.orientation, prediction.rotation)},
           .twist = {own.twist.linear + prediction.twist.linear,
                     own.twist.angular + prediction.twist.angular},
           .share = share});
      motion_ = prediction.motion;
      if (observer_ != nullptr) {
        observer_->on_prediction(received.peer, shared.def.id, now, position, age);
      }
    }
  }

  /// The share that is left of `share` while an average makes sense, and what a leader gets and a
  /// follower keeps beyond.
  double lead(Shared& shared, const Inbox::Received& received, SessionTime now,
              double share) const {
    // Compared at the stamp: what spins fast turns far within the age of an update.
    const pbd::Quat then = shared.history.at_time(received.update.stamp).pose.orientation;
    const double angle = pbd::rotation_between(then, received.update.pose.orientation).norm();
    const double doubt =
        std::clamp((angle - kLeadFromAngle) / (kLeadToAngle - kLeadFromAngle), 0.0, 1.0);
    if (confidence() < 1.0) return share;  // a newcomer leads nobody
    if (received.peer > transport_.self()) return share * (1.0 - doubt);
    if (doubt < 0.5 || shared.following_since == 0) shared.following_since = now;
    const double waited = kNs * static_cast<double>(now - shared.following_since);
    const double strength = (1.0 + doubt) * (1.0 + doubt * kLeadGrowth * waited * waited);
    return doubt > 0.0 ? 1.0 - std::pow(1.0 - share, strength) : share;
  }

  /// The paper's two steps: move this peer's own state towards the mean before it is simulated.
  void average_states() {
    for (const pbd::PoseTarget& target : targets_) {
      const pbd::BodyState own = world_.state(target.body);
      const double share = share_per_step(target.share, step_dt_);
      pbd::Correction correction;
      const pbd::Vec3 apart = target.pose.position - own.pose.position;
      if (apart.norm() > kTwoStepPosition) correction.translation = share * apart;
      if (target.rotation_error.norm() > kTwoStepAngle) {
        correction.rotation = share * target.rotation_error;
      }
      const pbd::Vec3 dv = target.twist.linear - own.twist.linear;
      if (dv.norm() > kTwoStepVelocity) correction.twist.linear = share * dv;
      const pbd::Vec3 dw = target.twist.angular - own.twist.angular;
      if (dw.norm() > kTwoStepVelocity) correction.twist.angular = share * dw;
      world_.set_pose(target.body, {own.pose.position + correction.translation,
                                    pbd::rotated(own.pose.orientation, correction.rotation)});
      world_.set_twist(target.body, {own.twist.linear + correction.twist.linear,
                                     own.twist.angular + correction.twist.angular});
      for (Shared& shared : shared_) {
        if (shared.def.body == target.body) shared.averaged = correction;
      }
    }
  }

  // --- remember and send ------------------------------------------------------------------------

  void mark_joints() {
    jointed_.assign(world_.slot_count(), 0);
    JointMarker marker(jointed_);
    for (const auto& block : world_.blocks()) {
      if (block->order() < static_cast<int>(pbd::SolveOrder::Contact)) block->links(marker);
    }
  }

  void remember(Shared& shared, SessionTime now, const pbd::Correction& correction) {
    const pbd::BodyState& state = world_.state(shared.def.body);
    shared.held = springs_.holds(shared.def.body);
    const bool jointed =
        shared.def.body.index < jointed_.size() && jointed_[shared.def.body.index] != 0;
    const bool coupled = shared.held || jointed || world_.in_contact(shared.def.body);
    shared.history.push(now, state.pose, state.twist, correction, coupled);
  }

  /// The share that others should give this peer's states of a body.
  double announced(const Shared& shared) const {
    if (shared.def.owner.has_value()) return shared.def.owner == transport_.self() ? 1.0 : 0.0;
    return options_.influence.baseline * confidence();
  }

  /// What this peer's own estimates weigh, against 1 for those of an established one: grows from 0
  /// after the first step, so that a newcomer takes over what the others know and is heard later.
  double confidence() const {
    if (options_.authority_ramp <= 0.0) return 1.0;
    const double since = started_ == 0 ? 0.0 : kNs * static_cast<double>(now_ - started_);
    return std::clamp(since / options_.authority_ramp, 0.0, 1.0);
  }

  /// A share is meant against a local weight of 1; this is what it comes to against confidence().
  double against_own(double share) const {
    const double weight = weight_of_share(share);
    return weight > 0.0 ? share_of_weight(weight / confidence()) : 0.0;
  }

  void send(SessionTime now) {
    states_.clear();
    for (const Shared& shared : shared_) {
      if (!world_.contains(shared.def.body)) continue;
      const pbd::BodyState& state = world_.state(shared.def.body);
      const MotionSample& sample = shared.history.newest();
      states_.push_back({.id = shared.def.id,
                         .pose = state.pose,
                         .twist = state.twist,
                         .influence = static_cast<float>(announced(shared)),
                         .stamp = now,
                         .flags = {.in_contact = sample.coupled && !shared.held,
                                   .held = shared.held,
                                   .owner_driven = shared.def.owner == transport_.self()}});
    }
    spring_states_.clear();
    spring_events_.clear();
    springs_.announce(now, spring_states_, spring_events_);
    post_records(std::span<const SpringUpdate>(spring_events_), kMaxSpringsPerPacket,
                 Delivery::Reliable);
    post_records(std::span<const SpringUpdate>(spring_states_), kMaxSpringsPerPacket,
                 Delivery::Newest);
    post_records(std::span<const StateUpdate>(states_), kMaxStatesPerPacket, Delivery::Newest);
  }

  template <class Record>
  void post_records(std::span<const Record> records, std::size_t most, Delivery delivery) {
    while (!records.empty()) {
      const std::size_t count = std::min(most, records.size());
      outgoing_.clear();
      encode(records.first(count), outgoing_);
      post_all(delivery);
      records = records.subspan(count);
    }
  }

  void post_all(Delivery delivery) {
    if (outgoing_.empty()) return;
    for (const PeerStatus& peer : transport_.peers()) {
      if (peer.connected && transport_.post(peer.id, outgoing_, delivery)) {
        stats_.bytes_sent += outgoing_.size();
      }
    }
  }

  PeerOptions options_;
  pbd::World& world_;
  Transport& transport_;
  Springs springs_;
  Inbox inbox_;
  std::unique_ptr<Predictor> predictor_;
  PeerObserver* observer_ = nullptr;
  PeerStats stats_;
  std::vector<Shared> shared_;  ///< by id
  std::vector<std::pair<PeerId, SessionTime>> farewells_;
  std::vector<std::uint8_t> jointed_;
  SessionTime now_ = 0;
  SessionTime started_ = 0;
  SessionTime last_before_ = 0;
  SessionTime next_send_ = 0;
  double step_dt_ = 1.0 / 60.0;
  pbd::TargetMotion motion_ = pbd::TargetMotion::WithBody;

  // Scratch, kept for its capacity.
  std::vector<Packet> packets_;
  DecodedPacket incoming_;
  std::vector<PeerEstimate> estimates_;
  std::vector<pbd::PoseTarget> targets_;
  std::vector<StateUpdate> states_;
  std::vector<SpringUpdate> spring_states_;
  std::vector<SpringUpdate> spring_events_;
  std::vector<std::byte> outgoing_;
};

Peer::Peer(pbd::World& world, Transport& transport, const PeerOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(world, transport, options);
  world.set_target_source(this);
}
Peer::~Peer() { impl_->release_world(this); }

void Peer::share(const ShareDef& def) { impl_->share(def); }
void Peer::set_owner(const SharedId& id, std::optional<PeerId> owner) {
  impl_->set_owner(id, owner);
}
GrabId Peer::grab(const GrabDef& def) { return impl_->grab(def); }
void Peer::move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now) {
  impl_->springs().move(id, anchor_w, now);
}
void Peer::release(GrabId id) { impl_->springs().release(id, impl_->now()); }
bool Peer::held(const SharedId& id) const { return impl_->held(id); }
void Peer::before_step(SessionTime now) { impl_->before_step(now); }
void Peer::after_step(SessionTime now) { impl_->after_step(now); }
void Peer::leave(SessionTime now) { impl_->leave(now); }
const PeerStats& Peer::stats() const { return impl_->stats(); }
void Peer::set_observer(PeerObserver* observer) { impl_->set_observer(observer); }

void Peer::collect(const pbd::World& /*world*/, double /*dt*/, std::vector<pbd::PoseTarget>& out) {
  impl_->collect(out);
}

}  // namespace tandem::consensus
