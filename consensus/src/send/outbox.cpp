// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Which states are due to which peer, and which of them the budget allows.
#include "send/outbox.h"

#include <algorithm>
#include <cmath>

#include "common/body_state.h"
#include "common/ranges.h"
#include "common/session_time.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

using pbd::Vec3;

// docs/history/network-figures.md ("States in few bytes") measures the effect of these at 64 and
// 256 kbit/s.

/// s: an error in velocity counts as the error in position after this time.
constexpr double kExpectedFor = 0.05;
/// m: the unit of errors if every state is sent and they only determine the order.
constexpr double kUnit = 1e-3;
/// Number of states that announce a change, as some get lost.
constexpr std::uint8_t kTold = 3;

// Priority per 1/60 s of waiting.
constexpr double kFirst = 1e6;
constexpr double kWaits = 0.2;  // for waiting alone
constexpr double kNews = 50.0;
constexpr double kMaxMissed = 100.0;  // tolerances: larger errors count alike

/// s: interval between messages of bodies that came to rest, many in one packet.
constexpr double kCommitEvery = 0.1;
/// s: a peer that hears nothing for longer no longer relies on bodies at rest.
/// tests/consensus/sending_test.cpp fails at a third of it and at three times as much.
constexpr double kAliveEvery = 0.1;
/// s: shortest interval between repetitions of everything.
constexpr double kTellAgain = 1.0;

/// Part of the capacity reported by the transport: the link carries other traffic too.
constexpr double kOfBorne = 0.9;
constexpr double kBytesPerKbit = 125.0;
/// s of the budget that may be saved: more would only queue on the line.
constexpr double kBurst = 0.04;
/// Small budgets may save this many headers. With a third of them half of a budget is not used
/// (tests/consensus/sending_test.cpp).
constexpr double kSaved = 10.0;
/// A packet of states alone must be this many times as long as its headers. At a third of it copies
/// are 23 mm apart where they have to be within 20 (tests/consensus/sending_test.cpp).
constexpr double kWorthwhile = 6.0;
/// Part of the budget for springs' anchors.
constexpr double kAnchorPart = 0.25;

// bytes, approximate
constexpr double kMovingBytes = 27.0;
constexpr double kRestingBytes = 14.0;
constexpr double kOrientationBytes = 6.0;
constexpr double kAssignmentBytes = 20.0;
constexpr double kMessageBytes = 22.0;

/// Whether the state differs in kind from the last one sent.
bool is_news(const UpdateFlags& a, const UpdateFlags& b) {
  return a.resting != b.resting || a.held != b.held || a.owner_driven != b.owner_driven ||
         a.leads != b.leads;
}

bool is_free(const UpdateFlags& flags) {
  return !flags.in_contact && !flags.held && !flags.owner_driven && !flags.resting;
}

}  // namespace

std::uint16_t Outbox::assign_index(const SharedId& id) {
  indexed_.push_back(id);
  return static_cast<std::uint16_t>(indexed_.size() - 1);
}

bool Outbox::renew(std::size_t most) {
  if (indexed_.size() <= most) return false;
  indexed_.clear();
  table_ = 0;
  for (Link& link : links_) link.sent.clear();
  return true;
}

void Outbox::tell_again(PeerId peer, SessionTime now) {
  for (Link& link : links_) {
    if (link.to != peer || seconds(now - link.told) < kTellAgain) continue;
    link.told = now;
    link.sent.clear();
  }
}

void Outbox::forget_strangers(std::span<const PeerStatus> peers) {
  const auto gone = [peers](const auto& link) {
    const auto at = ranges::lower_bound(peers, link.to, &PeerStatus::id);
    return at == peers.end() || at->id != link.to;
  };
  std::erase_if(links_, gone);
  std::erase_if(stats_.links, gone);
}

Outbox::Link& Outbox::link_to(PeerId peer) {
  auto it = ranges::lower_bound(links_, peer, &Link::to);
  if (it == links_.end() || it->to != peer) {
    stats_.links.insert(stats_.links.begin() + (it - links_.begin()), LinkStats{.to = peer});
    it = links_.insert(it, Link{.to = peer, .sent = {}});
  }
  return *it;
}

void Outbox::send(std::span<const PeerStatus> peers, std::span<const OutgoingState> states,
                  const AnchorMessages& anchors, const Interest* interest, SessionTime now) {
  // Session times never recur: no predecessor's table has this number.
  if (table_ == 0) table_ = std::max(1U, static_cast<std::uint32_t>(now >> 16));
  forget_strangers(peers);
  for (const PeerStatus& status : peers) {
    Link& link = link_to(status.id);
    if (!status.connected) {
      link.up = false;
      link.sent = {};
      continue;
    }
    if (!link.up)
      link = Link{.to = link.to, .up = true, .last = now, .told = link.told, .sent = {}};
    link.kbit_per_s = options_.kbit_per_s;
    if (status.kbit_per_s > 0.0) {
      const double borne = kOfBorne * status.kbit_per_s;
      link.kbit_per_s = link.kbit_per_s > 0.0 ? std::min(link.kbit_per_s, borne) : borne;
    }
    refill(link, now);
    link.sent.resize(indexed_.size());
    look(link, states, interest, now);
    const std::uint64_t before = counters_of(link).bytes;
    choose(link, states, take_anchors(link, anchors));
    if (options_.format == StateFormat::Compact) post_indices(link, states);
    post_states(link, states, {}, true, now);
    post_states(link, states, post_anchors(link, anchors), false, now);
    withdraw(link);
    if (counters_of(link).bytes > before) link.posted = now;
    if (options_.tolerance > 0.0 && seconds(now - link.posted) >= kAliveEvery) {
      packet_.clear();
      encode(Alive{now}, packet_);
      post(link, Delivery::Newest);
      link.posted = now;
    }
  }
}

bool Outbox::has_room(const Link& link, double anchors) const {
  // A message longer than the most that can be saved goes on credit.
  return link.kbit_per_s == 0.0 || link.anchor_room >= std::min(anchors, most_saved(link));
}

double Outbox::take_anchors(Link& link, const AnchorMessages& anchors) {
  taken_.clear();
  double along = 0.0;
  const std::size_t count = anchors.ends.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t turn = (link.turn + i) % count;
    // The last packet's headers are charged to the states that share it.
    const double headers = taken_.empty() ? 0.0 : kPacketOverhead;
    const double bytes = headers + static_cast<double>(anchors[turn].size());
    if (!has_room(link, bytes)) break;
    link.anchor_room -= bytes;
    along += bytes;
    taken_.push_back(turn);
  }
  if (taken_.empty()) return 0.0;
  link.turn = (taken_.back() + 1) % count;
  return along;
}

double Outbox::most_saved(const Link& link) const {
  return std::max({kBurst * kBytesPerKbit * link.kbit_per_s, kSaved * kPacketOverhead, 300.0});
}

void Outbox::refill(Link& link, SessionTime now) const {
  const double dt = std::max(0.0, seconds(now - link.last));
  link.last = now;
  if (link.kbit_per_s == 0.0) {
    // Without a budget nothing is saved, and nothing owed if there is one later.
    link.room = link.anchor_room = 0.0;
    return;
  }
  const double rate = kBytesPerKbit * link.kbit_per_s;
  const double most = most_saved(link);
  link.room = std::min(link.room + dt * rate, most);
  link.anchor_room = std::min(link.anchor_room + kAnchorPart * dt * rate, most);
}

double Outbox::missed(const Sent& sent, const OutgoingState& state, SessionTime now) const {
  const StateUpdate& update = state.update;
  const double dt = seconds(now - sent.stamp);
  const Vec3 gravity = is_free(sent.flags) ? state.gravity : Vec3(Vec3::Zero());
  const Vec3 position = sent.pose.position + dt * sent.twist.linear + 0.5 * dt * dt * gravity;
  const Vec3 velocity = sent.twist.linear + dt * gravity;
  const double apart = (update.pose.position - position).norm() +
                       kExpectedFor * (update.twist.linear - velocity).norm();
  double angle = kExpectedFor * (update.twist.angular - sent.twist.angular).norm();
  if (update.oriented) {
    const pbd::Quat expected = pbd::rotated(sent.pose.orientation, dt * sent.twist.angular);
    angle += small_angle(expected, update.pose.orientation);
  }
  // A resting body's state is repeated if it has moved.
  if (update.flags.resting) return std::max(apart / kRestDistance, angle / kRestAngle);
  const double unit = options_.tolerance > 0.0 ? options_.tolerance : kUnit;
  return std::max(apart / unit, angle / options_.angle_tolerance);
}

bool Outbox::influence_differs(Sent& sent, float influence) {
  const float off = std::abs(influence - sent.influence);
  const float larger = std::max(influence, sent.influence);
  const bool settled = influence == sent.announced;
  sent.announced = influence;
  return off > (settled ? 0.01F : 0.5F) * larger;
}

bool Outbox::is_due(Sent& sent, const OutgoingState& state, bool limited, SessionTime now,
                    Due& due) const {
  const StateUpdate& update = state.update;
  const bool known = sent.stamp != 0;
  const bool selective = options_.tolerance > 0.0;
  const double since = seconds(now - sent.stamp);
  const bool weighs = selective || limited;
  const double missed_by = !weighs ? 0.0 : known ? missed(sent, state, now) : kMaxMissed;
  const bool other_influence = influence_differs(sent, update.influence);
  if (known && is_news(update.flags, sent.flags)) sent.news = kTold;
  const bool resting = update.flags.resting && !state.first;
  if (resting) sent.news = 0;
  due.reliable = selective && resting && (!sent.committed || missed_by > 1.0 || other_influence);
  const bool is_told = sent.news > 0 || sent.jumped > 0;
  const double refresh = resting ? options_.rest_refresh : options_.refresh;
  if (selective && !due.reliable && !is_told && known && since >= 0.0 && since < refresh &&
      (resting || missed_by <= 1.0)) {
    sent.priority = 0.0;
    return false;
  }
  const double error = std::min(missed_by, kMaxMissed);
  sent.priority += state.first ? kFirst : kWaits + error * error;
  if (is_told) sent.priority += kNews;
  due.priority = sent.priority;
  return true;
}

void Outbox::look(Link& link, std::span<const OutgoingState> states, const Interest* interest,
                  SessionTime now) {
  due_.clear();
  withdrawn_.clear();
  for (Sent& sent : link.sent) sent.here = false;
  const bool commits = seconds(now - link.committed) >= kCommitEvery;
  for (std::uint32_t i = 0; i < states.size(); ++i) {
    const OutgoingState& state = states[i];
    Sent& sent = link.sent[state.index];
    if (interest != nullptr && !interest->concerns(link.to, state.update.id, state.update.pose)) {
      continue;
    }
    sent.here = true;
    if (state.update.flags.teleported && !sent.jumping) sent.jumped = kTold;
    sent.jumping = state.update.flags.teleported;
    Due due{.at = i};
    if (is_due(sent, state, link.kbit_per_s > 0.0, now, due)) {
      if (commits || !due.reliable) due_.push_back(due);
    } else {
      ++counters_of(link).unchanged;
    }
  }
  for (std::size_t index = 0; index < link.sent.size(); ++index) {
    Sent& sent = link.sent[index];
    if (sent.here || sent.stamp == 0) continue;
    if (sent.flags.resting) {
      StateUpdate last{.id = indexed_[index],
                       .pose = sent.pose,
                       .influence = sent.influence,
                       .stamp = now,
                       .flags = sent.flags};
      last.flags.resting = false;
      withdrawn_.push_back({static_cast<std::uint16_t>(index), last});
    }
    sent = Sent{.indexed = sent.indexed};
  }
}

void Outbox::charge(double bytes) {
  for (Link& link : links_) link.room -= bytes;
}

double Outbox::size_of(const StateUpdate& update) const {
  if (options_.format == StateFormat::Full) return static_cast<double>(kStateBytes);
  const double whole = update.flags.resting ? kRestingBytes : kMovingBytes;
  return update.oriented ? whole : whole - kOrientationBytes;
}

void Outbox::choose(Link& link, std::span<const OutgoingState> states, double along) {
  if (link.kbit_per_s == 0.0 || due_.empty()) return;
  const double room = link.room - along;
  const double headers = kPacketOverhead + kMessageBytes;
  const double packet = static_cast<double>(packet_limit(transport_, Delivery::Newest));
  const auto unnamed = [&](const Due& due) {
    return options_.format == StateFormat::Compact && !link.sent[states[due.at].index].indexed;
  };
  const auto cost = [&](const Due& due) {
    return size_of(states[due.at].update) + (unnamed(due) ? kAssignmentBytes : 0.0);
  };
  const auto with_headers = [&](double bytes, bool reliable) {
    return bytes + headers * (std::ceil(bytes / packet) + (reliable ? 1.0 : 0.0));
  };
  double total = 0.0;
  bool reliable = false;
  for (const Due& due : due_) {
    total += cost(due);
    reliable = reliable || due.reliable || unnamed(due);
  }
  if (with_headers(total, reliable) <= room) return;
  // States that share a packet with others need not be worth its headers.
  if (along == 0.0 && room < kWorthwhile * kPacketOverhead) {
    counters_of(link).deferred += due_.size();
    due_.clear();
    return;
  }
  std::sort(due_.begin(), due_.end(), [](const Due& a, const Due& b) {
    return a.priority != b.priority ? a.priority > b.priority : a.at < b.at;
  });
  double bytes = 0.0;
  reliable = false;
  std::size_t kept = 0;
  for (const Due& due : due_) {
    const bool asks_reliable = reliable || due.reliable || unnamed(due);
    const double with_it = bytes + cost(due);
    if (with_headers(with_it, asks_reliable) > room) continue;
    bytes = with_it;
    reliable = asks_reliable;
    due_[kept++] = due;
  }
  counters_of(link).deferred += due_.size() - kept;
  due_.resize(kept);
  ranges::sort(due_, &Due::at);
}

}  // namespace tandem::consensus
