// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "couple/ownership.h"

#include <algorithm>

namespace tandem::consensus {
namespace {

// Without either constant tests/consensus/ownership_test.cpp fails.
/// ns: a touch after a longer pause is a new act.
constexpr SessionTime kActPause = 100'000'000;
/// ns: interval between requests for the same body.
constexpr SessionTime kAskAgain = 250'000'000;

}  // namespace

void Ownership::update(std::span<const Receiver::OwnershipNews> news) {
  for (const Receiver::OwnershipNews& one : news) {
    if (SharedBody* const shared = data_.bodies.find(one.update.body)) {
      hear(shared->tenure, one.from, one.update);
    } else {
      ++data_.stats.unknown_ids;
    }
  }
  PeerId lowest = 0;  // lowest id present; determined once, only if needed
  for (std::size_t i = 0; i < data_.bodies.size(); ++i) {
    SharedBody& shared = data_.bodies[i];
    if (shared.def.owner.has_value() || !data_.world.contains(shared.def.body)) continue;
    constexpr std::uint8_t kOwn = Springs::kShared | Springs::kAlone | Activity::kTouchedByOwn;
    const bool acting = (activity_.bits(shared.def.body.index) & kOwn) != 0;
    Tenure& body = shared.tenure;
    if (body.heard == 0) body.heard = data_.now;
    hear_claims(body, data_.inbox.newest_at(i));
    act(body, shared.def.id, acting);
    if (!abandoned(body)) continue;
    if (lowest == 0) {
      connections_.refresh();
      lowest = data_.self();
      const std::span<const PeerId> others = connections_.connected();
      if (!others.empty()) lowest = std::min(lowest, others.front());
    }
    if (lowest != data_.self()) continue;
    body.owner = data_.self();
    body.since = body.heard = data_.now;
  }
  post();
}

bool Ownership::acts(const Tenure& body) const {
  return body.began != 0 && data_.now - body.acted <= kActPause;
}

void Ownership::hear(Tenure& body, PeerId from, const OwnershipUpdate& message) {
  const SessionTime now = data_.now;
  const PeerId self = data_.self();
  if (message.event == OwnershipEvent::Grant) {
    if (from != body.owner) return;
    body.owner = message.to;
    body.since = std::min(message.stamp, now);  // else no later claim could win
    body.heard = now;
    return;
  }
  if (body.owner != self || from == self) return;
  // Acts in the future are not believed.
  const SessionTime began = std::min(message.stamp, now);
  const bool earlier = began < body.began || (began == body.began && self < from);
  if (acts(body) && earlier) return;
  body.owner = from;
  body.since = body.heard = now;
  outgoing_.push_back(
      {.body = message.body, .to = from, .event = OwnershipEvent::Grant, .stamp = now});
}

void Ownership::hear_claims(Tenure& body, std::span<const Inbox::Received> newest) const {
  const Inbox::Received* latest = nullptr;
  for (const Inbox::Received& received : newest) {
    const StateUpdate& update = received.update;
    if (update.influence < 1.0F || update.stamp <= body.since) continue;
    // Sorted by peer: for equal stamps the lower id wins.
    if (latest == nullptr || update.stamp > latest->update.stamp) latest = &received;
  }
  if (latest == nullptr) return;
  if (body.owner == data_.self() && data_.self() < latest->peer) return;
  body.owner = latest->peer;
  body.heard = std::min(std::max(body.heard, latest->arrival), data_.now);
}

void Ownership::act(Tenure& body, const SharedId& id, bool acting) {
  const SessionTime now = data_.now;
  if (body.owner == data_.self()) body.heard = now;
  if (!acting) return;
  if (!acts(body)) {
    body.began = now;
    body.asked = 0;
  }
  body.acted = now;
  const bool due = body.asked == 0 || now - body.asked > kAskAgain;
  if (!due || body.owner == data_.self() || body.owner == 0) return;
  body.asked = now;
  outgoing_.push_back(
      {.body = id, .to = body.owner, .event = OwnershipEvent::Request, .stamp = body.began});
}

bool Ownership::abandoned(const Tenure& body) const {
  const SessionTime patience = to_ns(data_.options.influence.max_age);
  return body.owner != data_.self() && body.heard != 0 && data_.now - body.heard > patience;
}

void Ownership::post() {
  if (outgoing_.empty()) return;
  connections_.refresh();
  for (const OwnershipUpdate& update : outgoing_) {
    const std::span<const OwnershipUpdate> message(&update, 1);
    const bool grant = update.event == OwnershipEvent::Grant;
    connections_.post(grant ? Connections::kToAll : update.to, message, Delivery::Reliable);
  }
  outgoing_.clear();
}

}  // namespace tandem::consensus
