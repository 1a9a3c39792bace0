// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "receive/receiver.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/ranges.h"
#include "tandem/pbd/cpu_timer.h"

namespace tandem::consensus {
namespace {

/// ns: a farewell covers stamps up to this far ahead, see InboxOptions::max_future.
constexpr SessionTime kMaxAhead = 1'000'000'000;

/// Bounds the memory against made-up ids. Beyond it the peer silent for the longest is dropped for
/// a new one, and of those heard in this step the newest. Active peers are heard in each step. All
/// states of a body are compared with each other: if 100 new ids come in each step, 256 cost 0.5 ms
/// a step and 1024 4.6 ms (member_budget_test, [.measure]).
constexpr std::size_t kMaxPeers = 256;

/// Budget of a member: twice as many updates as the local rate, at least 60 per second, of all
/// bodies, four times a user's largest number of springs and some more; four updates at once. What
/// exceeds it is not decoded, and after a while its sender is dropped.
constexpr double kMinRate = 60.0;
constexpr double kTimes = 2.0;
constexpr double kMore = 4.0 * static_cast<double>(Springs::kMaxPerPeer) + 32.0;
constexpr double kUpdatesAtOnce = 4.0;
/// s, longest time between own steps for which packets are decoded at once.
constexpr double kLongestGap = 0.5;

/// Cost of processing a packet, in states.
double work_of(const DecodedPacket& packet) {
  const std::size_t light = packet.assignments.size() + packet.indices_wanted.size() +
                            packet.alive.size() + packet.leaves.size() + packet.ownership.size() +
                            packet.receipts.size();
  const std::size_t springs = packet.springs.size() + packet.anchors.size();
  return 1.0 +
         static_cast<double>(packet.states.size() + packet.compact.size() + springs +
                             packet.acts.size()) +
         0.25 * static_cast<double>(light);
}

/// Other peers may have this multiple of the bodies shared here, and this many more.
constexpr std::size_t kTimesIndices = 4;
constexpr std::size_t kMoreIndices = 4096;

}  // namespace

void Receiver::receive() {
  packets_.clear();
  unknown_.clear();
  ownership_.clear();
  wants_all_.clear();
  data_.transport.drain(packets_);
  senders_.clear();
  if (data_.options.timestamps == TimestampSource::Arrival && !packets_.empty()) {
    senders_ = data_.transport.peers();
  }
  pbd::CpuLaps cpu;
  for (std::size_t next = 0; next < packets_.size();) {
    std::size_t count = 0;
    for (; next < packets_.size() && count < batch_.size(); ++next) {
      if (decode_admitted(packets_[next], batch_[count].content)) {
        batch_[count++].packet = &packets_[next];
      }
    }
    cpu.add(data_.stats.parse_s);
    for (Decoded& decoded : std::span(batch_).first(count)) take_packet(decoded);
    cpu.add(data_.stats.process_s);
  }
  // Drop states that have expired, and their senders' influence with them.
  data_.inbox.prune(data_.now);
}

bool Receiver::decode_admitted(const Packet& packet, DecodedPacket& out) {
  if (packet.from == 0) return false;  // reserved id
  ++data_.stats.packets_received;
  pbd::TokenBucket& budget = meet(packet.from).budget;
  if (!budget.admits(data_.now)) {
    ++data_.report_of(packet.from).over_budget;
    if (budget.abused()) {
      budget.forgive();
      data_.transport.drop(packet.from, "says more than a member may, see docs/network.md");
    }
    return false;
  }
  const CodecResult result = decode(packet.bytes, out);
  if (!result.ok()) {
    ++data_.stats.packets_rejected;
    data_.transport.drop(packet.from, "undecodable packet: " + result.reason());
    return false;
  }
  data_.stats.updates_received += out.states.size();
  budget.spend(work_of(out));
  return true;
}

void Receiver::take_packet(Decoded& decoded) {
  const Packet& packet = *decoded.packet;
  const auto met = ranges::lower_bound(met_, packet.from, &Met::peer);
  // Dropped in favour of peers whose packets came after it.
  if (met == met_.end() || met->peer != packet.from) return;
  std::swap(incoming_, decoded.content);
  keep_allowed(packet.from, packet.role);
  if (data_.options.timestamps == TimestampSource::Arrival || is_of_another_clock(*met)) {
    date(packet);
  }
  take_in(*met);
}

bool Receiver::is_of_another_clock(Met& met) {
  const auto newest = newest_stamp(incoming_);
  if (!newest) return met.astray >= SenderClocks::kAstrayCount;
  const SessionTime now = data_.now;
  const bool astray =
      *newest < now - SenderClocks::kLongestWay || *newest > now + to_ns(data_.options.max_future);
  if (!astray) {
    if (met.astray > 0) sender_clocks_.forget(met.peer);
    met.astray = 0;
  } else if (met.astray == 0) {
    met.astray = 1;
    met.astray_since = now;
  } else if (met.astray < SenderClocks::kAstrayCount - 1 ||
             now - met.astray_since >= SenderClocks::kAstrayFor) {
    met.astray = std::min(met.astray + 1, SenderClocks::kAstrayCount);
  }
  return met.astray >= SenderClocks::kAstrayCount;
}

void Receiver::date(const Packet& packet) {
  if (senders_.empty()) senders_ = data_.transport.peers();
  const auto [received, round_trip] = arrival_of(packet, senders_, data_.now);
  if (const auto newest = newest_stamp(incoming_)) {
    shift_stamps(incoming_, sender_clocks_.hear(packet.from, *newest, received, round_trip));
    return;
  }
  // Anchors are stamped when moved, and farewells and events may have waited for a link: their
  // stamps say little about the clock.
  const auto known = sender_clocks_.shift(packet.from);
  shift_stamps(incoming_, known ? *known
                                : SenderClocks::guess(newest_stamp_of_others(incoming_), received,
                                                      round_trip));
}

void Receiver::set_budget(pbd::TokenBucket& budget) const {
  const double update = static_cast<double>(data_.bodies.size()) + kMore;
  const double rate = kTimes * std::max(kMinRate, data_.options.update_hz) * update;
  // A peer that seldom steps decodes at once what came meanwhile.
  const double since = std::min(data_.step_dt, kLongestGap);
  budget.set(rate, std::max(kUpdatesAtOnce * update, rate * since));
}

void Receiver::keep_allowed(PeerId from, Role role) {
  if (role == Role::Share) return;
  std::size_t denied = 0;
  const auto deny = [&denied](auto& records) {
    denied += records.size();
    records.clear();
  };
  deny(incoming_.states);
  deny(incoming_.compact);
  deny(incoming_.ownership);
  incoming_.assignments.clear();
  if (role == Role::Watch) {
    deny(incoming_.springs);
    deny(incoming_.anchors);
    deny(incoming_.acts);
  }
  if (denied > 0) data_.report_of(from).not_allowed += denied;
}

Receiver::Met& Receiver::meet(PeerId from) {
  auto at = ranges::lower_bound(met_, from, &Met::peer);
  if (at == met_.end() || at->peer != from) {
    if (met_.size() >= kMaxPeers) {
      const auto silent =
          std::min_element(met_.begin(), met_.end(), [](const Met& l, const Met& r) {
            return std::pair(l.last, -l.since) < std::pair(r.last, -r.since);
          });
      forget(silent->peer);
      met_.erase(silent);
      at = ranges::lower_bound(met_, from, &Met::peer);
    }
    at = met_.insert(at, {.peer = from, .since = data_.now});
    at->budget =
        pbd::TokenBucket(0.0, std::numeric_limits<double>::max());  // filled by set_budget()
    at->acts = pbd::TokenBucket(Acts::kPerSecond, Acts::kAtOnce);
  }
  set_budget(at->budget);
  at->last = data_.now;
  return *at;
}

void Receiver::part_from(PeerId peer) {
  data_.inbox.remove_peer(peer);
  connections_.indices().forget(peer);
  for (SharedBody& shared : data_.bodies) {
    std::erase_if(shared.heard, [peer](const Heard& heard) { return heard.peer == peer; });
  }
  data_.springs.drop_peer(peer, data_.now);
}

void Receiver::forget(PeerId peer) {
  part_from(peer);
  data_.inbox.forget_peer(peer);
  sender_clocks_.forget(peer);
  std::erase_if(data_.reports, [peer](const auto& report) { return report.peer == peer; });
}

void Receiver::take_in(Met& sender) {
  const PeerId from = sender.peer;
  const SessionTime farewell = sender.farewell;
  data_.inbox.add_peer(from);
  data_.report_of(from);
  // Without agreement and owners nothing uses the states.
  const bool unheard = data_.options.coupling == Coupling::None && !data_.bodies.have_owners();
  for (const StateUpdate& update : incoming_.states) {
    if (!unheard) take_in_state(from, update, farewell);
  }
  if (!unheard) take_in_compact(from, farewell);
  take_in_springs(from);
  take_in_acts(sender);
  for (const OwnershipUpdate& update : incoming_.ownership) ownership_.push_back({from, update});
  if (!incoming_.leaves.empty()) {
    part_from(from);
    // Peers' steps are slightly ahead of each other; a stamp far ahead must not block a successor.
    sender.farewell = std::min(data_.now + kMaxAhead, incoming_.leaves.back().stamp);
  }
}

void Receiver::take_in_springs(PeerId from) {
  for (const SpringUpdate& update : incoming_.springs) take_in_spring(from, update);
  for (const AnchorUpdate& anchor : incoming_.anchors) {
    const SpringUpdate* const known = data_.springs.last_of(from, anchor.spring);
    // The creation has not come, the spring or its body is gone, or the body is not here.
    if (known == nullptr || known->event == SpringEvent::Remove ||
        !instance_of(known->body).valid()) {
      continue;
    }
    SpringUpdate update = *known;
    update.event = SpringEvent::Change;
    update.anchor_w = anchor.anchor_w;
    update.anchor_velocity = anchor.anchor_velocity;
    update.stamp = anchor.stamp;
    take_in_spring(from, update);
  }
}

void Receiver::take_in_acts(Met& sender) {
  const PeerId from = sender.peer;
  for (const ActUpdate& update : incoming_.acts) {
    SharedBody* const shared = data_.bodies.find(update.body);
    // An owner's acts are in its states, and no other peer acts on its bodies.
    const bool may = shared != nullptr && data_.world.contains(shared->def.body) &&
                     data_.world.props(shared->def.body).type == pbd::BodyType::Dynamic &&
                     !shared->def.owner.has_value() &&
                     (!data_.changes_hands(*shared) || shared->tenure.owner == 0);
    if (may && data_.acts.receive(from, update, *shared,
                                  data_.inbox.newest_at(data_.bodies.index_of(*shared)),
                                  data_.confidence() >= 1.0, sender.acts, data_.now)) {
      continue;
    }
    ++data_.report_of(from).acts_refused;
    ++data_.stats.acts_refused;
  }
  for (const ActReceipt& receipt : incoming_.receipts) {
    const pbd::BodyId body = instance_of(receipt.body);
    if (body.valid()) data_.acts.receive(from, receipt, body);
  }
}

void Receiver::take_in_state(PeerId from, const StateUpdate& update, SessionTime farewell) {
  // Overtaken by the farewell; later stamps belong to a successor.
  if (update.stamp <= farewell) return;
  if (data_.inbox.offer(from, update, data_.now) != InboxVerdict::UnknownId) return;
  ++data_.stats.unknown_ids;
  if (unknown_.size() < Peer::kMaxUnknown) unknown_.push_back({from, update});
}

void Receiver::take_in_compact(PeerId from, SessionTime farewell) {
  const std::size_t most = kTimesIndices * data_.bodies.size() + kMoreIndices;
  for (const IndexAssignment& name : incoming_.assignments)
    connections_.indices().learn(from, name, most);
  bool missed = false;
  SessionTime alive = 0;
  for (CompactState& state : incoming_.compact) {
    alive = std::max(alive, state.update.stamp);
    const SharedId* const id = connections_.indices().find(from, state);
    if (id == nullptr) {
      missed = true;
      ++data_.stats.unknown_indices;
      continue;
    }
    state.update.id = *id;
    take_in_state(from, state.update, farewell);
  }
  data_.stats.updates_received += incoming_.compact.size();
  bool asks =
      !incoming_.compact.empty() && connections_.indices().should_ask(from, missed, data_.now);
  for (const StateUpdate& update : incoming_.states) alive = std::max(alive, update.stamp);
  for (const Alive& message : incoming_.alive) alive = std::max(alive, message.stamp);
  const bool selects = !incoming_.compact.empty() || !incoming_.alive.empty();
  if (alive > farewell && data_.inbox.note_alive(from, alive, data_.now) && selects) asks = true;
  if (asks) {
    const std::uint32_t table = incoming_.compact.empty() ? 0 : incoming_.compact.back().table;
    connections_.post(from, IndicesWanted{table}, Delivery::Reliable);
  }
  if (!incoming_.indices_wanted.empty()) wants_all_.push_back(from);
}

pbd::BodyId Receiver::instance_of(const SharedId& id) const {
  const SharedBody* const shared = data_.bodies.find(id);
  const bool here = shared != nullptr && data_.world.contains(shared->def.body);
  return here ? shared->def.body : pbd::BodyId{};
}

void Receiver::take_in_spring(PeerId from, const SpringUpdate& update) {
  const Springs::Verdict verdict =
      data_.springs.receive(from, update, instance_of(update.body), data_.now);
  if (verdict == Springs::Verdict::Taken) return;
  PeerReport& report = data_.report_of(from);
  if (verdict == Springs::Verdict::Limited) {
    ++report.springs_limited;
  } else {
    ++report.springs_refused;
    ++data_.stats.springs_refused;
  }
}

}  // namespace tandem::consensus
