// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/settlement.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/body_state.h"
#include "common/ranges.h"
#include "tandem/pbd/contact.h"

namespace tandem::consensus {
namespace {

/// m: lever that turns rotations into distances, so that 1 degree counts as 1 mm.
constexpr double kTurnLever = 0.06;
/// m: copies further apart rest in different places; no island sleeps by itself then.
constexpr double kApart = 1e-3;
/// ns: interval between examinations of the islands.
constexpr SessionTime kInterval = 100'000'000;
/// ns: a copy that has stayed in place for this long rests.
constexpr SessionTime kPatience = 1'000'000'000;
/// ns: time for an elected peer's copies to fall asleep, before they are taken over awake.
constexpr SessionTime kSleepPatience = 2'000'000'000;
/// m: a copy that stays within kStands stands. One that leaves kFarthest moves, however far away
/// others claim to be (tests/session/settlement_test.cpp, a ball that rolls).
constexpr double kStands = 3e-3;
constexpr double kFarthest = 0.15;
/// A peer whose distance to all others is this many times that of the most central copy is not
/// elected.
constexpr double kOutvoted = 1.4;
/// ns: a body that nobody acted on is not placed again sooner, whatever a liar says.
constexpr SessionTime kAgain = 5'000'000'000;
/// Takeovers of one pose: a body that slides away each time rests on something else here.
constexpr int kTries = 2;

double distance(const pbd::Pose& a, const pbd::Pose& b) {
  return (a.position - b.position).norm() + kTurnLever * small_angle(a.orientation, b.orientation);
}

/// A sleeping body has no velocity at all.
bool sleeps(const StateUpdate& update) {
  return update.flags.resting ||
         (update.twist.linear.isZero(0.0) && update.twist.angular.isZero(0.0));
}

/// m; below 0 the bodies overlap.
double least_gap(const pbd::World& world, const pbd::Manifold& manifold) {
  const pbd::Pose& a = world.states()[manifold.body_a].pose;
  const pbd::Pose& b = world.states()[manifold.body_b].pose;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < manifold.count; ++i) {
    const pbd::ManifoldPoint& point = manifold.points[static_cast<std::size_t>(i)];
    const pbd::Vec3 way = b.position + b.orientation * point.anchor_b_l -
                          (a.position + a.orientation * point.anchor_a_l);
    least = std::min(least, manifold.normal.dot(way) - manifold.radius_a - manifold.radius_b);
  }
  return least;
}

}  // namespace

void Settlement::settle() {
  if (data_.now >= looked_ && data_.now - looked_ < kInterval) return;
  const bool set_back = data_.now < looked_;
  looked_ = data_.now;
  data_.stats.bodies_apart = 0;
  find_bodies();
  if (set_back) {
    for (Body& body : bodies_) body.forget_times();
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) look_at(i);
  const bool tries = ranges::any_of(bodies_, [](const Body& body) { return body.trial != 0; });
  if (!tries && !ranges::any_of(bodies_, [](const Body& body) { return body.gap > kApart; })) {
    for (Body& body : bodies_) {
      body.slack = 0.0;
      body.elected = 0;
    }
    return;
  }
  find_islands();
  if (tries) look_at_taken();
  for (auto first = islands_.begin(); first != islands_.end();) {
    const std::uint32_t root = first->first;
    members_.clear();
    for (; first != islands_.end() && first->first == root; ++first) {
      members_.push_back(first->second);
    }
    settle_island();
  }
}

void Settlement::Body::forget_times() {
  copies.clear();
  touched = together = taken_at = 0;
  elected = 0;
}

void Settlement::find_bodies() {
  bool same = bodies_.size() == data_.bodies.size();
  for (std::size_t i = 0; same && i < bodies_.size(); ++i) {
    same = bodies_[i].id == data_.bodies[i].def.body;
  }
  if (same) return;
  std::vector<Body> before = std::exchange(bodies_, {});
  // Both lists are in the same order.
  auto next = before.begin();
  for (const SharedBody& shared : data_.bodies) {
    const auto found = std::find_if(next, before.end(),
                                    [&](const Body& body) { return body.id == shared.def.body; });
    bodies_.push_back(found != before.end() ? std::move(*found) : Body{.id = shared.def.body});
    if (found != before.end()) next = found + 1;
  }
}

void Settlement::look_at(std::size_t index) {
  SharedBody& shared = data_.bodies[index];
  const pbd::BodyId id = shared.def.body;
  Body& body = bodies_[index];
  shared.stands = false;
  body.free = false;
  body.gap = 0.0;
  if (!data_.world.contains(id) || shared.def.owner.has_value()) return;
  body.free = data_.confidence() >= 1.0 && !shared.held && shared.initiative.strength() == 0.0 &&
              data_.world.props(id).type == pbd::BodyType::Dynamic;
  const auto newest = data_.inbox.newest_at(index);
  if (body.copies.empty()) body.copies.push_back({.peer = data_.self()});
  const auto note = [&](Copy& copy, const pbd::Pose& pose) {
    constexpr double kPart = static_cast<double>(kInterval) / static_cast<double>(kPatience);
    const double still = std::clamp(body.slack, kStands, kFarthest);
    const bool rests = copy.since != 0 && distance(pose, copy.about) <= still;
    if (!rests) copy.since = data_.now;
    copy.about =
        rests ? moved({copy.about, {}}, gap({copy.about, {}}, {pose, {}}), kPart).pose : pose;
  };
  std::erase_if(body.copies, [&](const Copy& copy) {
    if (copy.peer == data_.self()) return false;
    const auto received = ranges::find(newest, copy.peer, &Inbox::Received::peer);
    return received == newest.end() || !counts(*received);
  });
  note(body.copies.front(), data_.world.pose(id));
  for (const Inbox::Received& received : newest) {
    const StateUpdate& update = received.update;
    if (!counts(received)) continue;
    // Springs are known here; other claims to act may be lies.
    const bool leads =
        update.flags.leads && (newest.size() < 2 || trust_.believes_lead(shared, received.peer));
    const bool by_hand = update.flags.owner_driven && trust_.believes_hands(newest.size());
    body.free = body.free && !leads && !by_hand;
    auto copy = ranges::find(body.copies, received.peer, &Copy::peer);
    if (copy == body.copies.end()) {
      copy = body.copies.insert(copy, Copy{.peer = received.peer});
    }
    const pbd::Pose there = pose_of(index, received);
    note(*copy, there);
    body.gap = std::max(body.gap, distance(there, own_at(index, received)));
  }
  if (body.gap > kApart) {
    body.together = 0;
    return;
  }
  if (body.together == 0) body.together = data_.now;
  if (data_.now - body.together >= kPatience) body.tries = 0;
}

bool Settlement::counts(const Inbox::Received& received) const {
  return received.update.influence > 0.0F && !latecomers_.is_late(received.peer);
}

std::uint32_t Settlement::root_of(std::uint32_t slot) {
  while (parents_[slot] != slot) slot = parents_[slot] = parents_[parents_[slot]];
  return slot;
}

void Settlement::find_islands() {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  const auto slots = static_cast<std::uint32_t>(data_.world.slot_count());
  parents_.resize(slots);
  for (std::uint32_t slot = 0; slot < slots; ++slot) parents_[slot] = slot;
  in_slot_.assign(slots, kNone);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (data_.world.contains(bodies_[i].id)) in_slot_[bodies_[i].id.index] = i;
  }
  for (const auto& [a, b] : activity_.joined()) {
    join(a, b);
    // A body jointed to one that is not shared cannot be placed elsewhere.
    if (in_slot_[a] == kNone && in_slot_[b] != kNone) bodies_[in_slot_[b]].free = false;
    if (in_slot_[b] == kNone && in_slot_[a] != kNone) bodies_[in_slot_[a]].free = false;
  }
  for (const pbd::Contact& contact : data_.world.contacts()->contacts()) {
    const pbd::Manifold& manifold = contact.manifold;
    join(manifold.body_a, manifold.body_b);
    for (const auto& [slot, other] : {std::pair(manifold.body_a, manifold.body_b),
                                      std::pair(manifold.body_b, manifold.body_a)}) {
      if (in_slot_[slot] == kNone) continue;
      Body& body = bodies_[in_slot_[slot]];
      body.touched = data_.now;
      if (body.trial == 0) continue;
      const std::size_t neighbour = in_slot_[other];
      if (neighbour != kNone && bodies_[neighbour].trial == body.trial) continue;
      body.misplaced = body.misplaced || least_gap(data_.world, manifold) < -kApart;
    }
  }
  islands_.clear();
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    if (in_slot_[slot] != kNone) islands_.emplace_back(root_of(slot), in_slot_[slot]);
  }
  std::sort(islands_.begin(), islands_.end());
}

bool Settlement::moves(std::uint32_t slot) const {
  return data_.world.all_props()[slot].type == pbd::BodyType::Dynamic;
}

void Settlement::join(std::uint32_t a, std::uint32_t b) {
  if (moves(a) && moves(b)) parents_[root_of(a)] = root_of(b);
}

void Settlement::look_at_taken() {
  misplaced_.clear();
  acted_on_.clear();
  const auto add_once = [](std::vector<std::uint64_t>& trials, std::uint64_t trial) {
    if (ranges::find(trials, trial) == trials.end()) trials.push_back(trial);
  };
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    if (body.trial == 0) continue;
    if (!body.free) add_once(acted_on_, body.trial);
    const bool hangs = data_.bodies[i].coupled;
    if (body.misplaced || (body.touched != data_.now && !hangs)) {
      add_once(misplaced_, body.trial);
    }
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    body.misplaced = false;
    const std::uint64_t trial = std::exchange(body.trial, 0);
    if (trial == 0 || !data_.world.contains(body.id)) continue;
    const bool acted_on = ranges::find(acted_on_, trial) != acted_on_.end();
    if (!acted_on && ranges::find(misplaced_, trial) != misplaced_.end()) {
      placement_.place(data_.bodies[i], {body.before, {}});
      data_.bodies[i].jumped = SharedBody::kJumpTold;
      body.tries = kTries;
    } else if (acted_on || !body.asleep) {
      data_.world.wake(body.id);
    }
  }
}

void Settlement::settle_island() {
  bool free = true;
  bool touches = false;
  double gap = 0.0;
  for (const std::size_t i : members_) {
    const Body& body = bodies_[i];
    free = free && body.free;
    touches = touches || (body.touched != 0 && data_.now - body.touched <= kPatience);
    gap = std::max(gap, body.gap);
  }
  for (const std::size_t i : members_) bodies_[i].slack = gap;
  if (!free) {
    for (const std::size_t i : members_) bodies_[i].taken_at = 0;
  }
  // A body that touches nothing cannot rest: it coasts, or hangs and swings.
  const PeerId elected = gap > kApart && free && touches ? elect() : 0;
  for (const std::size_t i : members_) {
    if (bodies_[i].elected == elected) continue;
    bodies_[i].elected = elected;
    bodies_[i].elected_since = data_.now;
  }
  if (elected != 0) follow(elected);
}

PeerId Settlement::elect() {
  candidates_.clear();
  for (const Copy& copy : bodies_[members_.front()].copies) {
    const bool at_rest = std::all_of(members_.begin(), members_.end(),
                                     [&](std::size_t i) { return rests(bodies_[i], copy.peer); });
    if (at_rest) candidates_.push_back({.peer = copy.peer});
  }
  // If the local copy moves, an earlier state of rest of the others is no news.
  if (candidates_.size() < 2 || candidates_.front().peer != data_.self()) return 0;
  for (const std::size_t i : members_) {
    for (std::size_t a = 0; a < candidates_.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const double way = apart(i, candidates_[a].peer, candidates_[b].peer);
        candidates_[a].cost += way;
        candidates_[b].cost += way;
      }
    }
  }
  double least = candidates_.front().cost;
  for (const Candidate& candidate : candidates_) least = std::min(least, candidate.cost);
  std::erase_if(candidates_, [&](const Candidate& candidate) {
    return candidate.peer != data_.self() && candidate.cost > kOutvoted * least;
  });
  PeerId elected = 0;
  for (const Candidate& candidate : candidates_) {
    if (candidate.cost > kOutvoted * least) continue;
    elected = elected == 0 ? candidate.peer : std::min(elected, candidate.peer);
  }
  // A single dissenter is no reason for an election among the others.
  const bool differ = ranges::any_of(candidates_, [&](const Candidate& candidate) {
    return std::any_of(members_.begin(), members_.end(),
                       [&](std::size_t i) { return apart(i, candidate.peer, elected) > kApart; });
  });
  return differ ? elected : 0;
}

void Settlement::follow(PeerId elected) {
  const auto all = [&](auto test) { return std::all_of(members_.begin(), members_.end(), test); };
  const bool here = all([&](std::size_t i) { return apart(i, data_.self(), elected) <= kApart; });
  if (elected != data_.self() && !here) {
    const bool asleep = all([&](std::size_t i) { return sleeps(said(i, elected)->update); });
    const bool tried = all([&](std::size_t i) {
      const Body& body = bodies_[i];
      const pbd::Pose there = pose_of(i, *said(i, elected));
      return body.tries >= kTries && distance(there, body.taken_pose) <= kApart;
    });
    if (tried) {
      data_.stats.bodies_apart += members_.size();
    } else if (may_take_over(elected, asleep)) {
      return take_over(elected, asleep);
    } else {
      return;
    }
  }
  for (const std::size_t i : members_) data_.bodies[i].stands = true;
}

bool Settlement::may_take_over(PeerId elected, bool asleep) const {
  const Body& first = bodies_[members_.front()];
  if (!asleep && data_.now - first.elected_since < kSleepPatience) return false;
  return std::all_of(members_.begin(), members_.end(), [&](std::size_t i) {
    const Body& body = bodies_[i];
    return body.taken_at == 0 || data_.now - body.taken_at >= kAgain ||
           distance(pose_of(i, *said(i, elected)), body.taken_pose) <= kApart;
  });
}

void Settlement::take_over(PeerId elected, bool asleep) {
  ++trials_;
  for (const std::size_t i : members_) {
    SharedBody& shared = data_.bodies[i];
    Body& body = bodies_[i];
    const pbd::Pose there = pose_of(i, *said(i, elected));
    const bool moves = distance(data_.world.pose(body.id), there) > kApart;
    body.tries = distance(there, body.taken_pose) <= kApart ? body.tries + 1 : 1;
    body.before = data_.world.pose(body.id);
    body.taken_pose = there;
    body.taken_at = data_.now;
    body.trial = trials_;
    body.asleep = asleep;
    body.slack = 0.0;
    shared.stands = true;
    for (Copy& copy : body.copies) copy.since = 0;
    pbd::BodyActivity activity = data_.world.activities()[body.id.index];
    activity.asleep = true;
    data_.world.resume(body.id, {there, {}}, activity);
    data_.history.restart(body.id.index, data_.world);
    ++shared.placed;
    if (!moves) continue;
    shared.jumped = SharedBody::kJumpTold;
    ++data_.stats.bodies_placed;
  }
}

bool Settlement::rests(const Body& body, PeerId peer) const {
  const auto copy = ranges::find(body.copies, peer, &Copy::peer);
  return copy != body.copies.end() && copy->since != 0 && data_.now - copy->since >= kPatience;
}

const Inbox::Received* Settlement::said(std::size_t index, PeerId peer) const {
  const auto newest = data_.inbox.newest_at(index);
  const auto received = ranges::find(newest, peer, &Inbox::Received::peer);
  return received != newest.end() ? &*received : nullptr;
}

pbd::Pose Settlement::pose_of(std::size_t index, const Inbox::Received& received) const {
  pbd::Pose pose = received.update.pose;
  if (!received.update.oriented || !data_.bodies[index].def.orientation) {
    pose.orientation = own_at(index, received).orientation;
  }
  return pose;
}

pbd::Pose Settlement::own_at(std::size_t index, const Inbox::Received& received) const {
  return data_.history.state_at(bodies_[index].id.index, data_.inbox.holds_until(received)).pose;
}

double Settlement::apart(std::size_t index, PeerId a, PeerId b) const {
  if (a == b) return 0.0;
  if (a == data_.self()) std::swap(a, b);
  const Inbox::Received& there = *said(index, a);
  const pbd::Pose pose = pose_of(index, there);
  return distance(pose, b == data_.self() ? own_at(index, there) : pose_of(index, *said(index, b)));
}

}  // namespace tandem::consensus
