// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sending of what is due alone, and what the receiver makes of states that are rounded or rest.
#include <algorithm>
#include <cmath>
#include <span>

#include "peer_impl.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

using pbd::Vec3;

// What lies still: it has been slow and within these for kLyingFor.
constexpr double kLyingSpeed = 0.01;     // m/s
constexpr double kLyingSpin = 0.02;      // rad/s
constexpr double kLyingDistance = 5e-4;  // m
constexpr double kLyingAngle = 2e-3;     // rad
constexpr double kLyingFor = 0.25;       // s

/// s: springs are told in full so often, for whom their creation has not reached; and to newcomers.
constexpr double kSpringsEvery = 2.0;

/// rad: how far rounding turns a body at most. Half a quantum in each of three components c moves
/// the largest, L >= 1/2, by at most (|a| + |b| + |c|) / L <= 3 of it, and turns by twice the
/// length of all four: 2 sqrt(3 + 9) half quanta.
constexpr double kRoundedAngle = 3.4641016151377544 * kOrientationQuantum;

/// So many times as many bodies as are shared here, and so many more, others may have.
constexpr std::size_t kTimesNames = 4;
constexpr std::size_t kMoreNames = 4096;

/// Nearer to zero by at most `limit`.
double shrunk(double value, double limit) {
  return std::copysign(std::max(0.0, std::abs(value) - limit), value);
}

bool is_slow(const pbd::Twist& twist) {
  return twist.linear.squaredNorm() < kLyingSpeed * kLyingSpeed &&
         twist.angular.squaredNorm() < kLyingSpin * kLyingSpin;
}

double angle_between(const pbd::Quat& a, const pbd::Quat& b) {
  return 2.0 * (a.conjugate() * b).vec().norm();
}

}  // namespace

void Peer::Impl::take_in_compact(PeerId from, SessionTime farewell, SessionTime now) {
  const std::size_t most = kTimesNames * shared_.size() + kMoreNames;
  for (const NameUpdate& name : incoming_.names) names_.learn(from, name, most);
  bool missed = false;
  SessionTime alive = 0;
  for (CompactState& state : incoming_.compact) {
    alive = std::max(alive, state.update.stamp);
    const SharedId* const id = names_.find(from, state);
    if (id == nullptr) {
      missed = true;
      ++stats_.unknown_indices;
      continue;
    }
    state.update.id = *id;
    take_in_state(from, state.update, farewell, now);
  }
  stats_.updates_received += incoming_.compact.size();
  bool asks = !incoming_.compact.empty() && names_.should_ask(from, missed, now);
  for (const StateUpdate& update : incoming_.states) alive = std::max(alive, update.stamp);
  for (const Alive& message : incoming_.alive) alive = std::max(alive, message.stamp);
  const bool selects = !incoming_.compact.empty() || !incoming_.alive.empty();
  if (alive > farewell && inbox_.note_alive(from, alive, now) && selects) asks = true;
  if (asks) {
    outgoing_.clear();
    encode(NamesWanted{incoming_.compact.empty() ? 0 : incoming_.compact.back().table}, outgoing_);
    post_to(from, Delivery::Reliable);
  }
  if (!incoming_.names_wanted.empty() && outbox_ != nullptr) outbox_->tell_again(from, now);
}

void Peer::Impl::take_in_anchors(PeerId from, SessionTime now) {
  for (const AnchorUpdate& anchor : incoming_.anchors) {
    const SpringUpdate* const known = springs_.last_of(from, anchor.spring);
    // Of a spring whose creation has not come, or that is gone.
    if (known == nullptr || known->event == SpringEvent::Remove) continue;
    const Shared* shared = find(known->body);
    if (shared == nullptr || !world_.contains(shared->def.body)) continue;
    SpringUpdate update = *known;
    update.event = SpringEvent::Change;
    update.anchor_w = anchor.anchor_w;
    update.anchor_velocity = anchor.anchor_velocity;
    update.stamp = anchor.stamp;
    receive_spring(from, update, shared->def.body, now);
  }
}

const StateUpdate& Peer::Impl::as_meant(const Inbox::Received& received, const Shared& shared) {
  const StateUpdate& update = received.update;
  const bool oriented = update.oriented && shared.def.orientation;
  const bool lies = update.flags.resting || (update.rounded && is_slow(update.twist));
  if (!lies && oriented) return update;
  meant_ = update;
  meant_.stamp = inbox_.holds_until(received);
  const pbd::Pose own = history_.state_at(shared.def.body.index, meant_.stamp).pose;
  if (!oriented) meant_.pose.orientation = own.orientation;
  if (!lies || !update.rounded) return meant_;
  // What rounds to the same is the same: else every resting body would be drawn to the lattice.
  for (int i = 0; i < 3; ++i) {
    const double apart = update.pose.position[i] - own.position[i];
    meant_.pose.position[i] = own.position[i] + shrunk(apart, 0.5 * kPositionQuantum);
  }
  if (oriented) {
    const Vec3 turn = pbd::rotation_between(own.orientation, update.pose.orientation);
    const double angle = turn.norm();
    const double left = angle > 0.0 ? shrunk(angle, kRoundedAngle) / angle : 0.0;
    meant_.pose.orientation = pbd::rotated(own.orientation, left * turn);
  }
  return meant_;
}

bool Peer::Impl::lies_still(Shared& shared, const pbd::BodyState& state, SessionTime now) const {
  const bool acted_on = shared.held || shared.hard.active || shared.initiative.strength() > 0.0;
  if (acted_on || shared.jumped > 0 || !is_slow(state.twist)) {
    shared.lies_since = 0;
    return false;
  }
  const bool stays = shared.lies_since != 0 &&
                     (state.pose.position - shared.lies.position).norm() < kLyingDistance &&
                     angle_between(shared.lies.orientation, state.pose.orientation) < kLyingAngle;
  if (!stays) {
    shared.lies = state.pose;
    shared.lies_since = now;
  }
  return seconds(now - shared.lies_since) >= kLyingFor;
}

void Peer::Impl::encode_own_anchors() {
  const std::size_t most = packet_limit(transport_, Delivery::Newest);
  told_in_full_.clear();
  std::span<const SpringUpdate> left(spring_states_);
  while (!left.empty()) {
    const std::size_t before = anchors_.bytes.size();
    const std::size_t count = encode_anchors(left, before + most, told_in_full_, anchors_.bytes);
    if (count == 0) break;  // packets too short for any anchor
    if (anchors_.bytes.size() > before) anchors_.ends.push_back(anchors_.bytes.size());
    left = left.subspan(count);
  }
  spring_states_.swap(told_in_full_);
}

void Peer::Impl::send_selected(SessionTime now) {
  const auto renew = [this](std::size_t most) {
    if (!outbox_->renew(most)) return;
    for (Shared& shared : shared_) shared.name = kNoName;
  };
  const auto fresh = std::ranges::count(shared_, kNoName, &Shared::name);
  renew(Outbox::kMaxNames - static_cast<std::size_t>(fresh));
  selectable_.clear();
  for (Shared& shared : shared_) {
    if (!world_.contains(shared.def.body)) continue;
    if (shared.name == kNoName) shared.name = outbox_->name(shared.def.id);
    OutgoingState& state = selectable_.emplace_back();
    state.name = static_cast<std::uint16_t>(shared.name);
    state.gravity = world_.all_props()[shared.def.body.index].gravity_scale * world_.gravity();
    state.update = state_of(shared, now);
    UpdateFlags& flags = state.update.flags;
    const bool own_spring =
        (acting_[shared.def.body.index] & (Springs::kShared | Springs::kAlone)) != 0;
    state.first = flags.leads || flags.owner_driven || own_spring;
    flags.resting = lies_still(shared, world_.state(shared.def.body), now);
    if (flags.resting) state.update.twist = {};
  }
  const auto by_name = [](const OutgoingState& a, const OutgoingState& b) {
    return a.name < b.name;
  };
  if (!std::is_sorted(selectable_.begin(), selectable_.end(), by_name)) {
    std::sort(selectable_.begin(), selectable_.end(), by_name);
  }
  anchors_.clear();
  const bool in_full = options_.sending.format == StateFormat::Full || !newcomers_.empty() ||
                       seconds(now - springs_told_) >= kSpringsEvery;
  if (in_full) springs_told_ = now;
  if (!in_full) encode_own_anchors();
  double beside = 0.0;
  const auto post = [&](Delivery delivery) {
    beside += static_cast<double>(outgoing_.size()) + options_.sending.packet_overhead;
    post_all(delivery);
  };
  post_records(std::span<const SpringUpdate>(spring_events_), kSpringBytes, Delivery::Reliable,
               [&] { post(Delivery::Reliable); });
  post_records(std::span<const SpringUpdate>(spring_states_), kSpringBytes, Delivery::Newest,
               [&] { post(Delivery::Newest); });
  outbox_->charge(beside);
  outbox_->send(company_, selectable_, anchors_, interest_, now, stats_);
  // Afterwards: bodies that have gone are then withdrawn.
  constexpr std::size_t kSpareNames = 1024;
  renew(2 * shared_.size() + kSpareNames);
}

}  // namespace tandem::consensus
