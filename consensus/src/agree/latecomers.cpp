// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/latecomers.h"

#include <algorithm>
#include <utility>

#include "common/ranges.h"
#include "common/session_time.h"
#include "replay/replay_start.h"

namespace tandem::consensus {
namespace {

/// A peer is late if its newest state is older than this times the median age plus a step (states
/// are not sent in step). Within it a replay costs hardly more than without that peer.
constexpr double kOlder = 1.3;

/// s: additional age allowed for a single body, whose states may have been lost.
constexpr double kLost = 0.1;

}  // namespace

void Latecomers::look() {
  none_ = true;
  // Hysteresis: a peer at the limit would move the replay's start to and fro, and begin new
  // replays.
  const double older = std::exchange(carried_, 0) != 0 ? 1.0 : kOlder;
  members_.clear();
  for (std::size_t i = 0; i < data_.bodies.size(); ++i) {
    auto member = members_.begin();
    for (const Inbox::Received& received : data_.inbox.newest_at(i)) {
      while (member != members_.end() && member->peer < received.peer) ++member;
      if (member == members_.end() || member->peer != received.peer) {
        member = members_.insert(member, {.peer = received.peer});
      }
      if (received.update.flags.resting) continue;
      member->newest = std::max(member->newest, received.update.stamp);
    }
  }
  if (members_.size() < 2) return;
  ages_.clear();
  for (Member& member : members_) {
    if (member.newest == 0) member.newest = data_.inbox.alive(member.peer);
    ages_.push_back(std::max(0.0, seconds(data_.now - member.newest)));
  }
  std::sort(ages_.begin(), ages_.end());
  // With three or more peers the newer half is in time.
  const double usual = ages_[(ages_.size() - 1) / 2];
  const SendOptions& sending = data_.options.sending;
  double most = older * usual + data_.step_dt + (sending.selects() ? sending.refresh : 0.0);
  if (ages_.size() == 2 && ages_.back() > most) {
    const auto by_newest = [](const Member& l, const Member& r) { return l.newest < r.newest; };
    carried_ = std::min_element(members_.begin(), members_.end(), by_newest)->peer;
    most = std::max(most, ReplaySchedule::goes_back(data_.options.replay.budget) * data_.step_dt);
  }
  for (Member& member : members_) {
    member.late = seconds(data_.now - member.newest) > most;
    if (member.late) ++data_.report_of(member.peer).late;
  }
  none_ = !(ages_.back() > most);
  oldest_ = data_.now - to_ns(most + kLost);
}

bool Latecomers::is_late(PeerId peer) const {
  if (none_) return false;
  const auto member = ranges::lower_bound(members_, peer, &Member::peer);
  return member != members_.end() && member->peer == peer && member->late;
}

bool Latecomers::is_late(const Inbox::Received& received) const {
  return is_late(received.peer) || data_.inbox.holds_until(received) < oldest_;
}

std::span<const Inbox::Received> Latecomers::in_time(const SharedBody& shared,
                                                     std::span<const Inbox::Received> newest,
                                                     bool& guessed) {
  guessed = false;
  if (none_) return newest;
  heard_.clear();
  bool owner_late = false;
  for (const Inbox::Received& received : newest) {
    const bool late = is_late(received);
    // A body dragged by a hand without physics is not replayed.
    const bool by_hand =
        received.update.flags.owner_driven && data_.options.mode != InputMode::Soft;
    const bool owns = shared.def.owner == received.peer;
    owner_late = owner_late || (owns && late);
    if (!late || owns || by_hand) heard_.push_back(received);
  }
  guessed = heard_.empty() || owner_late;
  if (heard_.empty()) return newest;
  return heard_;
}

}  // namespace tandem::consensus
