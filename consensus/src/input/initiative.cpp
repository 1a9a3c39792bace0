// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/initiative.h"

#include <algorithm>

#include "common/ranges.h"
#include "common/session_time.h"

namespace tandem::consensus {
namespace {

/// s: time that followers need, once they have the news, to come close enough to be listened to. At
/// a third of it tests/consensus/initiative_test.cpp fails: a leader that has come to rest is not
/// pulled away.
constexpr double kSettling = 0.15;
/// s, over which the leader begins to listen again.
constexpr double kFading = 0.15;
/// Peers that claim to lead one body; a transport connects no more peers than that.
constexpr std::size_t kMaxOthers = 1024;

}  // namespace

void Initiative::update(const Acting& acting, double round_trip, SessionTime now) {
  if (acting.other) {
    end();
    return;
  }
  if (acting.own) {
    acted_ = now;
    until_ = now + to_ns(round_trip + kSettling);
    flies_ = true;
    strength_ = 1.0;
    return;
  }
  if (acted_ == 0) return;
  // In flight a body does what the followers know: without this a throw is held back
  // (tests/consensus/initiative_test.cpp).
  flies_ = flies_ && !acting.contact;
  if (flies_) until_ = std::max(until_, now);
  strength_ = std::clamp(1.0 - 1e-9 * static_cast<double>(now - until_) / kFading, 0.0, 1.0);
  if (strength_ == 0.0) end();
}

void Initiative::hear(PeerId peer, bool leads, SessionTime stamp) {
  const auto it = ranges::find(others_, peer, [](const auto& other) { return other.first; });
  if (!leads) {
    if (it != others_.end()) others_.erase(it);
    return;
  }
  const SessionTime since = it != others_.end() ? it->second : stamp;
  if (it == others_.end()) {
    // A peer that has left never withdraws its claim.
    if (others_.size() >= kMaxOthers) others_.erase(others_.begin());
    others_.emplace_back(peer, stamp);
  }
  // The later leader knows of the earlier one. Of two that acted at the same moment both may give
  // way, but never neither: each hears of the other a little after it acted.
  if (acted_ != 0 && since > acted_) end();
}

}  // namespace tandem::consensus
