// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "ownership.h"

#include <algorithm>

#include "session_time.h"

namespace tandem::consensus {
namespace {

/// ns: without touching for so long, the next touch is another act.
constexpr SessionTime kActPause = 100'000'000;
/// ns: between two requests for the same body.
constexpr SessionTime kAskAgain = 250'000'000;

}  // namespace

Ownership::Ownership(PeerId self, double patience) : self_(self), patience_(to_ns(patience)) {}

void Ownership::insert(std::size_t index) {
  bodies_.insert(bodies_.begin() + static_cast<std::ptrdiff_t>(index), Body{});
}

void Ownership::remove(std::size_t index) {
  bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(index));
}

bool Ownership::acts(const Body& body, SessionTime now) const {
  return body.began != 0 && now - body.acted <= kActPause;
}

void Ownership::hear(std::size_t index, PeerId from, const OwnershipUpdate& message,
                     SessionTime now) {
  Body& body = bodies_[index];
  if (message.event == OwnershipEvent::Grant) {
    if (from != body.owner) return;
    body.owner = message.to;
    body.since = message.stamp;
    body.heard = now;
    return;
  }
  if (body.owner != self_ || from == self_) return;
  // Nobody acts in the future, whatever is claimed.
  const SessionTime began = std::min(message.stamp, now);
  const bool earlier = began < body.began || (began == body.began && self_ < from);
  if (acts(body, now) && earlier) return;
  body.owner = from;
  body.since = now;
  body.heard = now;
  outgoing_.push_back(
      {.body = message.body, .to = from, .event = OwnershipEvent::Grant, .stamp = now});
}

void Ownership::hear_claims(Body& body, std::span<const Inbox::Received> newest,
                            SessionTime now) const {
  const Inbox::Received* latest = nullptr;
  for (const Inbox::Received& received : newest) {
    const StateUpdate& update = received.update;
    if (update.influence < 1.0F || update.stamp <= body.since) continue;
    // Received by ascending peer: of the same stamp the lower id stays.
    if (latest == nullptr || update.stamp > latest->update.stamp) latest = &received;
  }
  if (latest == nullptr) return;
  if (body.owner == self_ && self_ < latest->peer) return;
  body.owner = latest->peer;
  body.heard = std::min(std::max(body.heard, latest->arrival), now);
}

void Ownership::update(std::size_t index, const SharedId& id,
                       std::span<const Inbox::Received> newest, bool acting, SessionTime now) {
  Body& body = bodies_[index];
  if (body.heard == 0) body.heard = now;
  hear_claims(body, newest, now);
  if (body.owner == self_) body.heard = now;
  if (acting) {
    if (!acts(body, now)) {
      body.began = now;
      body.asked = 0;
    }
    body.acted = now;
  }
  const bool due = body.asked == 0 || now - body.asked > kAskAgain;
  if (!acting || !due || body.owner == self_ || body.owner == 0) return;
  body.asked = now;
  outgoing_.push_back(
      {.body = id, .to = body.owner, .event = OwnershipEvent::Request, .stamp = body.began});
}

bool Ownership::abandoned(std::size_t index, SessionTime now) const {
  const Body& body = bodies_[index];
  return body.owner != self_ && body.heard != 0 && now - body.heard > patience_;
}

void Ownership::claim(std::size_t index, SessionTime now) {
  Body& body = bodies_[index];
  body.owner = self_;
  body.since = now;
  body.heard = now;
}

}  // namespace tandem::consensus
