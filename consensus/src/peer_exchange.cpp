// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "cpu_clock.h"
#include "peer_impl.h"

namespace tandem::consensus {
namespace {

/// ns: a farewell ends what is stamped up to this long from now, see InboxOptions::max_future.
constexpr SessionTime kMaxAhead = 1'000'000'000;

/// Who makes up ids does not fill the memory: of so many that have been heard the one that has been
/// silent for the longest is forgotten for a new one, of those that are heard now the newest. Who
/// acts is heard in each step. All that is said of a body is compared with all the rest: where 100
/// ids come in each step, for good, 256 cost 0.5 ms a step and 1024 4.6 ms (member_budget_test,
/// [.measure]).
constexpr std::size_t kMostPeers = 256;
/// ns: no packet is under way for longer. Whose packets all seem to be, or come from the future,
/// has another clock; so many in a row over so many ns show it, where single ones have waited for a
/// link.
constexpr SessionTime kLongestWay = 10'000'000'000;
constexpr int kAstrayCount = 8;
constexpr SessionTime kAstrayFor = 1'000'000'000;

/// Of updates as often as our own, or as 60 a second, all bodies, all springs that one may have and
/// some more, twice; four updates at once. A member who says more is read no further, and after a
/// while dropped.
constexpr double kLeastRate = 60.0;
constexpr double kTimes = 2.0;
constexpr double kMore = static_cast<double>(Springs::kMaxPerPeer) + 32.0;
constexpr double kUpdatesAtOnce = 4.0;
/// s: between two own steps, for what may be read at once.
constexpr double kLongestGap = 0.5;

/// What a packet costs to take in, in states.
double work_of(const DecodedPacket& packet) {
  const std::size_t light = packet.names.size() + packet.names_wanted.size() + packet.alive.size() +
                            packet.leaves.size() + packet.ownership.size();
  const std::size_t springs = packet.springs.size() + packet.anchors.size();
  return 1.0 + static_cast<double>(packet.states.size() + packet.compact.size() + springs) +
         0.25 * static_cast<double>(light);
}

/// Marks bodies that a joint or a spring (not a contact) holds to another or to the world, and
/// collects pairs of bodies that move.
class JointMarker final : public pbd::LinkVisitor {
 public:
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  JointMarker(const pbd::World& world, std::vector<std::uint8_t>& marks, Pairs& pairs)
      : props_(world.all_props()), marks_(marks), pairs_(pairs) {}
  void link(std::uint32_t a, std::uint32_t b) override {
    if (a != pbd::BodyId::kNone) marks_[a] = 1;
    if (b != pbd::BodyId::kNone) marks_[b] = 1;
    if (moves(a) && moves(b)) pairs_.emplace_back(a, b);
  }

 private:
  bool moves(std::uint32_t slot) const {
    return slot != pbd::BodyId::kNone && props_[slot].type == pbd::BodyType::Dynamic;
  }

  std::span<const pbd::BodyProps> props_;
  std::vector<std::uint8_t>& marks_;
  Pairs& pairs_;
};

}  // namespace

void Peer::Impl::receive(SessionTime now) {
  packets_.clear();
  unknown_.clear();
  transport_.drain(packets_);
  senders_.clear();
  if (options_.dating == Dating::Receipt && !packets_.empty()) senders_ = transport_.peers();
  CpuLaps cpu;
  std::size_t next = 0;
  while (next < packets_.size()) {
    std::size_t count = 0;
    for (; next < packets_.size() && count < batch_.size(); ++next) {
      if (decode_admitted(packets_[next], batch_[count].content, now)) {
        batch_[count++].packet = &packets_[next];
      }
    }
    cpu.add(stats_.parse_s);
    for (Decoded& decoded : std::span(batch_).first(count)) {
      const Packet& packet = *decoded.packet;
      const auto met = std::ranges::lower_bound(met_, packet.from, {}, &Met::peer);
      // Forgotten for others whose packets came after it.
      if (met == met_.end() || met->peer != packet.from) continue;
      std::swap(incoming_, decoded.content);
      keep_allowed(packet.from, packet.role);
      if (options_.dating == Dating::Receipt || is_of_another_clock(*met, now)) date(packet, now);
      take_in(packet.from, now);
    }
    cpu.add(stats_.process_s);
  }
  // States that have expired since count for nothing, nor does who sent them.
  inbox_.prune(now);
}

bool Peer::Impl::decode_admitted(const Packet& packet, DecodedPacket& out, SessionTime now) {
  if (packet.from == 0) return false;  // no peer has this id
  ++stats_.packets_received;
  Budget& budget = meet(packet.from, now).budget;
  if (!budget.admits(now)) {
    ++report_of(packet.from).over_budget;
    if (budget.abused()) {
      budget.forgive();
      transport_.drop(packet.from, "says more than a member may, see docs/network.md");
    }
    return false;
  }
  const CodecResult result = decode(packet.bytes, out);
  if (!result.ok()) {
    ++stats_.packets_rejected;
    transport_.drop(packet.from, "undecodable packet: " + result.reason());
    return false;
  }
  stats_.updates_received += out.states.size();
  budget.spend(work_of(out));
  return true;
}

bool Peer::Impl::is_of_another_clock(Met& met, SessionTime now) {
  const auto newest = newest_stamp(incoming_);
  if (!newest) return met.astray >= kAstrayCount;
  const bool astray = *newest < now - kLongestWay || *newest > now + to_ns(options_.max_future);
  if (!astray) {
    if (met.astray > 0) sender_clocks_.forget(met.peer);
    met.astray = 0;
  } else if (met.astray == 0) {
    met.astray = 1;
    met.astray_since = now;
  } else if (met.astray < kAstrayCount - 1 || now - met.astray_since >= kAstrayFor) {
    met.astray = std::min(met.astray + 1, kAstrayCount);
  }
  return met.astray >= kAstrayCount;
}

void Peer::Impl::date(const Packet& packet, SessionTime now) {
  if (senders_.empty()) senders_ = transport_.peers();
  const auto [received, round_trip] = arrival_of(packet, senders_, now);
  if (const auto newest = newest_stamp(incoming_)) {
    shift_stamps(incoming_, sender_clocks_.hear(packet.from, *newest, received, round_trip));
    return;
  }
  // Anchors are stamped when they are moved, and farewells and events may have waited for a link:
  // they say little about the clock.
  const auto known = sender_clocks_.shift(packet.from);
  shift_stamps(incoming_, known ? *known
                                : SenderClocks::guess(newest_stamp_of_others(incoming_), received,
                                                      round_trip));
}

void Peer::Impl::set_budget(Budget& budget) const {
  const double update = static_cast<double>(shared_.size()) + kMore;
  const double rate = kTimes * std::max(kLeastRate, options_.update_hz) * update;
  // Who steps seldom reads at once what came meanwhile.
  const double since = std::min(step_dt_, kLongestGap);
  budget.set(rate, std::max(kUpdatesAtOnce * update, rate * since));
}

void Peer::Impl::keep_allowed(PeerId from, Role role) {
  if (role == Role::Share) return;
  std::size_t denied = 0;
  const auto deny = [&denied](auto& records) {
    denied += records.size();
    records.clear();
  };
  deny(incoming_.states);
  deny(incoming_.compact);
  deny(incoming_.ownership);
  incoming_.names.clear();
  if (role == Role::Watch) {
    deny(incoming_.springs);
    deny(incoming_.anchors);
  }
  if (denied > 0) report_of(from).not_allowed += denied;
}

Peer::Impl::Met& Peer::Impl::meet(PeerId from, SessionTime now) {
  auto at = std::ranges::lower_bound(met_, from, {}, &Met::peer);
  if (at == met_.end() || at->peer != from) {
    if (met_.size() >= kMostPeers) {
      const auto silent = std::ranges::min_element(
          met_, {}, [](const Met& met) { return std::pair(met.last, -met.since); });
      forget(silent->peer, now);
      met_.erase(silent);
      at = std::ranges::lower_bound(met_, from, {}, &Met::peer);
    }
    at = met_.insert(at, {.peer = from, .since = now, .last = now, .budget = {}});
    at->budget = Budget(0.0, std::numeric_limits<double>::max());  // filled by set_budget()
  }
  set_budget(at->budget);
  at->last = now;
  return *at;
}

void Peer::Impl::part_from(PeerId peer, SessionTime now) {
  inbox_.remove_peer(peer);
  names_.forget(peer);
  for (Shared& shared : shared_) {
    std::erase_if(shared.heard, [peer](const Heard& heard) { return heard.peer == peer; });
  }
  std::erase_if(farewells_, [peer](const auto& entry) { return entry.first == peer; });
  springs_.drop_peer(peer, now);
}

void Peer::Impl::forget(PeerId peer, SessionTime now) {
  part_from(peer, now);
  inbox_.forget_peer(peer);
  sender_clocks_.forget(peer);
  std::erase_if(reports_, [peer](const PeerReport& report) { return report.peer == peer; });
}

void Peer::Impl::take_in(PeerId from, SessionTime now) {
  inbox_.add_peer(from);
  report_of(from);
  const SessionTime farewell = farewell_of(from);
  // Nothing asks for states where nothing is agreed upon and nobody drives a body.
  const bool unheard = options_.coupling == Coupling::None && owners_.empty();
  for (const StateUpdate& update : incoming_.states) {
    if (!unheard) take_in_state(from, update, farewell, now);
  }
  if (!unheard) take_in_compact(from, farewell, now);
  for (const SpringUpdate& update : incoming_.springs) {
    const Shared* shared = find(update.body);
    if (shared == nullptr || !world_.contains(shared->def.body)) {
      ++stats_.springs_refused;
      ++report_of(from).springs_refused;
      continue;
    }
    receive_spring(from, update, shared->def.body, now);
  }
  take_in_anchors(from, now);
  if (!incoming_.ownership.empty()) hear_ownership(from, now);
  if (!incoming_.leaves.empty()) {
    part_from(from, now);
    // Peers' steps are some way ahead of each other's; a stamp far ahead must not bar a
    // successor.
    farewells_.emplace_back(from, std::min(now + kMaxAhead, incoming_.leaves.back().stamp));
  }
}

void Peer::Impl::take_in_state(PeerId from, const StateUpdate& update, SessionTime farewell,
                               SessionTime now) {
  // Overtaken by the farewell; what is stamped later comes from a successor.
  if (update.stamp <= farewell) return;
  if (inbox_.offer(from, update, now) != InboxVerdict::UnknownId) return;
  ++stats_.unknown_ids;
  if (unknown_.size() < kMaxUnknown) unknown_.push_back({from, update});
}

SessionTime Peer::Impl::farewell_of(PeerId peer) const {
  for (const auto& [id, stamp] : farewells_) {
    if (id == peer) return stamp;
  }
  return std::numeric_limits<SessionTime>::min();
}

void Peer::Impl::mark_joints() {
  jointed_.assign(world_.slot_count(), 0);
  joined_.clear();
  JointMarker marker(world_, jointed_, joined_);
  for (const auto& block : world_.blocks()) {
    if (block->order() < static_cast<int>(pbd::SolveOrder::Contact)) block->links(marker);
  }
}

void Peer::Impl::note_grip(Shared& shared) {
  const std::uint32_t slot = shared.def.body.index;
  const std::uint8_t acting = slot < acting_.size() ? acting_[slot] : std::uint8_t{0};
  constexpr std::uint8_t kHeld = Springs::kShared | Springs::kAlone | Springs::kRemote;
  shared.held = (acting & kHeld) != 0;
  const bool jointed = slot < jointed_.size() && jointed_[slot] != 0;
  const bool touches = (acting & kTouched) != 0 || world_.in_contact(shared.def.body);
  shared.coupled = shared.held || jointed || touches;
}

StateUpdate Peer::Impl::state_of(Shared& shared, SessionTime now) {
  const pbd::BodyState& state =
      shared.hard.active ? shared.hard.own : world_.state(shared.def.body);
  const bool by_hand = shared.hard.active || springs_.holds_alone(shared.def.body);
  const bool kinematic = world_.props(shared.def.body).type == pbd::BodyType::Kinematic;
  const bool leads = shared.initiative.strength() >= 1.0;
  const bool jumped = shared.jumped > 0;
  shared.jumped = std::max(shared.jumped - 1, 0);
  return {.id = shared.def.id,
          .pose = state.pose,
          .twist = state.twist,
          .influence = shared.hard.active ? 1.0F : static_cast<float>(announced(shared)),
          .stamp = now,
          .flags = {.in_contact = shared.coupled && !shared.held,
                    .held = shared.held,
                    .owner_driven = by_hand || (shared.def.owner == transport_.self() && kinematic),
                    .teleported = jumped,
                    .leads = leads},
          .oriented = shared.def.orientation};
}

void Peer::Impl::send(SessionTime now) {
  look_around();
  states_.clear();
  spring_states_.clear();
  spring_events_.clear();
  springs_.announce(now, spring_states_, spring_events_);
  if (outbox_ != nullptr) {
    send_selected(now);
    greet_newcomers();  // of bodies the outbox tells them by itself
    return;
  }
  for (Shared& shared : shared_) {
    if (world_.contains(shared.def.body)) states_.push_back(state_of(shared, now));
  }
  post_records(std::span<const SpringUpdate>(spring_events_), kSpringBytes, Delivery::Reliable,
               [this] { post_all(Delivery::Reliable); });
  post_records(std::span<const SpringUpdate>(spring_states_), kSpringBytes, Delivery::Newest,
               [this] { post_all(Delivery::Newest); });
  post_states();
  greet_newcomers();
}

void Peer::Impl::post_states() {
  if (interest_ == nullptr) {
    post_records(std::span<const StateUpdate>(states_), kStateBytes, Delivery::Newest,
                 [this] { post_all(Delivery::Newest); });
    return;
  }
  for (const PeerId peer : connected_) {
    collect_concerning(peer);
    post_records(std::span<const StateUpdate>(concerning_), kStateBytes, Delivery::Newest,
                 [&] { post_to(peer, Delivery::Newest); });
  }
}

void Peer::Impl::collect_concerning(PeerId peer) {
  concerning_.clear();
  for (const StateUpdate& state : states_) {
    const bool concerns = interest_ == nullptr || interest_->concerns(peer, state.id, state.pose);
    if (concerns) concerning_.push_back(state);
  }
}

void Peer::Impl::leave(SessionTime now) {
  look_around();
  outgoing_.clear();
  encode(Leave{.stamp = now}, outgoing_);
  post_all(Delivery::Reliable);
}

void Peer::Impl::post_all(Delivery delivery) {
  if (outgoing_.empty()) return;
  for (const PeerId peer : connected_) post_to(peer, delivery);
}

void Peer::Impl::post_to(PeerId to, Delivery delivery) {
  if (transport_.post(to, outgoing_, delivery)) stats_.bytes_sent += outgoing_.size();
}

}  // namespace tandem::consensus
