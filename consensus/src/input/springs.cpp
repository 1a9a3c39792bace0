// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/springs.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/ranges.h"
#include "common/session_time.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
namespace {

/// ns: a removed spring is remembered for this long, against late messages.
constexpr SessionTime kTombstone = 5'000'000'000;

/// ns: a message heard this far ahead of now was heard before the clock was set back.
constexpr SessionTime kSetBack = 500'000'000;

/// s: a hand without a move for longer stands still.
constexpr double kStill = 0.05;

std::uint32_t first_id(SessionTime now) {
  return std::max(1U, static_cast<std::uint32_t>(now / 1'000'000));
}

/// By number; null if there is none.
template <class Own>
auto find_own(Own& springs, GrabId id) -> decltype(springs.data()) {
  const auto it =
      ranges::lower_bound(springs, id.spring, [](const auto& own) { return own.spring; });
  return it != springs.end() && it->spring == id.spring ? &*it : nullptr;
}

template <class Own>
auto& own_spring(Own& springs, GrabId id) {
  auto* const own = find_own(springs, id);
  if (own == nullptr) {
    pbd::detail::refuse("Peer: grab", "one of this peer's springs, not released yet",
                        std::to_string(id.spring));
  }
  return *own;
}

}  // namespace

Springs::Springs(pbd::World& world, const PeerOptions& options)
    : world_(world),
      options_(options),
      limits_(world, options.robust),
      tethers_(world.add_block<pbd::Tethers>()) {}

Springs::~Springs() {
  try {
    world_.remove_block(tethers_);
  } catch (const std::invalid_argument&) {
    // The world was moved or assigned to: its blocks are elsewhere or gone.
  }
}

GrabId Springs::grab(const GrabDef& def, pbd::BodyId body) {
  auto place = own_.end();
  // The numbers wrap around: skip zero and those in use.
  for (;; ++next_) {
    if (next_ == 0) next_ = 1;
    place = ranges::lower_bound(own_, next_, &Own::spring);
    if (place == own_.end() || place->spring != next_) break;
  }
  const InputMode mode = def.mode.value_or(options_.mode);
  pbd::ConstraintId tether;
  pbd::Tether::Def limited;
  if (mode == InputMode::Hard) {
    pbd::detail::require_finite(def.attachment_l, "GrabDef", "attachment_l");
    pbd::detail::require_finite(def.anchor_w, "GrabDef", "anchor_w");
  } else {
    pbd::Tether::Def wanted{.body = body,
                            .anchor_l = def.attachment_l,
                            .anchor_w = def.anchor_w,
                            .stiffness = def.stiffness,
                            .damping = def.damping,
                            .max_force = def.max_force};
    limits_.limit(wanted);  // as the other peers do
    tether = tethers_.add(world_, wanted);
    limited = wanted;
  }
  own_.insert(place, {.spring = next_,
                      .revision = 1,
                      .def = def,
                      .body = body,
                      .mode = mode,
                      .tether = tether,
                      .limited = limited,
                      .hand = HandFilter(def.anchor_w, pbd::Vec3::Zero())});
  return {next_++};
}

bool Springs::holds(GrabId id) const {
  const Own* const own = find_own(own_, id);
  return own != nullptr && holds(*own);
}

void Springs::move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now) {
  Own& own = own_spring(own_, id);
  pbd::detail::require_finite(anchor_w, "Peer::move", "anchor_w");
  // If several positions have one time, the filter takes the first.
  if (now != own.moved) own.hand.add(seconds(now - own.moved), anchor_w, pbd::Vec3::Zero());
  own.def.anchor_w = anchor_w;
  own.moved = now;
}

void Springs::release(GrabId id, SessionTime now) {
  Own& own = own_spring(own_, id);
  ++own.revision;
  if (own.announced) pending_.push_back(own.message(SpringEvent::Remove, now));
  if (tethers_.contains(own.tether)) tethers_.remove(own.tether);
  own_.erase(own_.begin() + (&own - own_.data()));
}

SpringUpdate Springs::Own::message(SpringEvent event, SessionTime now) const {
  return {.spring = spring,
          .revision = revision,
          .event = event,
          .body = def.body,
          .attachment_l = def.attachment_l,
          .anchor_w = def.anchor_w,
          .anchor_velocity = velocity(),
          .stiffness = def.stiffness,
          .damping = def.damping,
          .max_force = def.max_force,
          .stamp = moved != 0 ? moved : now};
}

void Springs::let_go(Remote& remote, SessionTime when) {
  if (remote.live) remote.ended = when;
  if (pulls(remote)) tethers_.remove(remote.tether);
  if (std::exchange(remote.live, false)) share_out(remote.peer, remote.def.body);
}

bool Springs::make_room(PeerId from) {
  // Of one peer's springs, the one released longest ago.
  const auto forget_let_go = [this](std::span<Remote> all) {
    const auto oldest =
        std::min_element(all.begin(), all.end(), [](const Remote& a, const Remote& b) {
          return a.live != b.live ? b.live : a.heard < b.heard;
        });
    if (oldest == all.end() || oldest->live) return false;
    remote_.erase(remote_.begin() + (&*oldest - remote_.data()));
    return true;
  };
  if (of(from).size() >= kMaxPerPeer) return forget_let_go(of(from));
  if (remote_.size() < kMaxOfAll) return true;
  // The peer with most springs loses one: a released one first, then the lowest number. Sorted by
  // peer: it is the longest run.
  std::span<Remote> longest;
  for (std::size_t i = 0; i < remote_.size();) {
    const std::span<Remote> run = of(remote_[i].peer);
    if (run.size() > longest.size()) longest = run;
    i += run.size();
  }
  if (longest.size() <= of(from).size() + 1) return false;
  if (forget_let_go(longest)) return true;
  let_go(longest.front(), longest.front().heard);
  remote_.erase(remote_.begin() + (longest.data() - remote_.data()));
  return true;
}

void Springs::share_out(PeerId from, pbd::BodyId body) {
  if (!world_.contains(body)) return;
  const auto on_body = [&](const Remote& r) { return r.live && r.def.body == body; };
  SpringStrength sum;
  int together = 0;
  for (const Remote& r : of(from)) {
    if (!on_body(r)) continue;
    sum.add(r.def);
    ++together;
  }
  const SpringStrength share = limits_.share_of(body, sum);
  for (Remote& r : of(from)) {
    if (!on_body(r)) continue;
    r.share = share;
    r.together = together;
  }
}

std::vector<Springs::Remote>::iterator Springs::place_of(PeerId peer, std::uint32_t spring) {
  return std::lower_bound(
      remote_.begin(), remote_.end(), std::pair(peer, spring),
      [](const Remote& r, const auto& key) { return std::pair(r.peer, r.last.spring) < key; });
}

std::span<Springs::Remote> Springs::of(PeerId peer) {
  const auto first = ranges::lower_bound(remote_, peer, &Remote::peer);
  const auto last =
      std::find_if(first, remote_.end(), [&](const Remote& r) { return r.peer != peer; });
  return std::span(remote_).subspan(static_cast<std::size_t>(first - remote_.begin()),
                                    static_cast<std::size_t>(last - first));
}

Springs::Verdict Springs::receive(PeerId from, const SpringUpdate& update, pbd::BodyId body,
                                  SessionTime now) {
  auto it = place_of(from, update.spring);
  const bool known = it != remote_.end() && it->peer == from && it->last.spring == update.spring;
  if (known) {
    // Revisions do not go back. A removal has its own revision, so a late message after it is told
    // from one for a spring that was released because its peer was silent, and goes on now. Only a
    // creation later than everything heard is a new spring, of a successor under the same peer id.
    const bool later = update.stamp > it->last.stamp;
    const bool successor = later && update.event == SpringEvent::Create;
    if (update.revision < it->last.revision && !successor) return Verdict::Taken;
    if (update.revision == it->last.revision && !later) return Verdict::Taken;
  } else {
    if (update.event == SpringEvent::Remove && update.stiffness <= 0.0) return Verdict::Taken;
    if (!make_room(from)) return Verdict::Refused;
    it = remote_.insert(place_of(from, update.spring), {.peer = from});
  }
  const bool moved_body = known && it->live && it->last.body != update.body;
  const bool here = world_.contains(body);
  if (moved_body || !here || update.event == SpringEvent::Remove) let_go(*it, update.stamp);
  it->last = update;
  it->heard = now;
  if (update.event == SpringEvent::Remove) return Verdict::Taken;
  if (!here) return Verdict::Refused;
  if (!it->live) it->began = update.stamp;
  pbd::Tether::Def& def = it->def = {.body = body,
                                     .anchor_l = update.attachment_l,
                                     .anchor_w = update.anchor_w,
                                     .anchor_velocity = update.anchor_velocity,
                                     .stiffness = update.stiffness,
                                     .damping = update.damping,
                                     .max_force = update.max_force};
  const bool limited = limits_.limit(def);
  if (!(def.stiffness >= pbd::Tether::kMinStiffness) || !(def.max_force > 0.0) ||
      limits_.too_far(def) ||
      (!it->live && held_by(from, body) >= options_.robust.max_springs_per_body)) {
    let_go(*it, now);
    return Verdict::Refused;
  }
  if (!it->live || moved_body) it->hand.clear();
  it->hand.add(update.stamp, def.anchor_w, def.anchor_velocity);
  if (it->live) {
    tethers_.set(world_, it->tether, def);
  } else {
    it->tether = tethers_.add(world_, def);
    it->live = true;
  }
  share_out(from, body);
  return limited ? Verdict::Limited : Verdict::Taken;
}

const SpringUpdate* Springs::last_of(PeerId from, std::uint32_t spring) {
  const auto it = place_of(from, spring);
  const bool known = it != remote_.end() && it->peer == from && it->last.spring == spring;
  return known ? &it->last : nullptr;
}

void Springs::drop_peer(PeerId from, SessionTime now) {
  for (Remote& remote : remote_) {
    if (remote.peer != from) continue;
    let_go(remote, now);
    // Remembered with the highest revision: messages overtaken by the farewell must not revive it.
    remote.last.revision = std::numeric_limits<std::uint32_t>::max();
    remote.last.stamp = std::max(remote.last.stamp, now);
    remote.heard = now;
  }
}

void Springs::forget_body(pbd::BodyId body, SessionTime now) {
  for (Remote& remote : remote_) {
    if (pulls(remote) && remote.def.body == body) let_go(remote, now);
  }
  while (true) {
    const auto own = ranges::find(own_, body, &Own::body);
    if (own == own_.end()) return;
    release({own->spring}, now);
  }
}

void Springs::prepare(SessionTime now, double dt) {
  // Numbers continue from the clock (ms): a restarted peer is not taken for its predecessor, whose
  // springs the others still remember.
  if (next_ == 0) next_ = first_id(now);
  const auto timeout = static_cast<SessionTime>(options_.spring_timeout / kNs);
  for (Remote& remote : remote_) {
    const bool set_back = remote.heard - now > kSetBack;
    if (remote.live && (set_back || now - remote.heard > timeout)) let_go(remote, now);
    if (!pulls(remote)) continue;
    pbd::Tether::Def def = pull_at(remote, now);
    limits_.slow(world_, dt, remote.together, def);
    tethers_.set(world_, remote.tether, def);
  }
  // A spring that is still held returns with its next update.
  std::erase_if(remote_, [&](const Remote& r) {
    return !r.live && (now - r.heard > kTombstone || r.heard - now > kSetBack);
  });
  for (Own& own : own_) {
    if (!tethers_.contains(own.tether)) continue;
    double since = own.moved != 0 ? seconds(now - own.moved) : 0.0;
    if (since > kStill) {
      // The others must learn that the hand stands still and holds on.
      own.hand = HandFilter(own.def.anchor_w, pbd::Vec3::Zero());
      own.moved = now;
      since = 0.0;
    }
    pbd::Tether::Def def = tethers_.def(own.tether);
    def.stiffness = own.limited.stiffness;
    def.damping = own.limited.damping;
    def.max_force = own.limited.max_force;
    SpringStrength sum;
    int count = 0;
    for (const Own& other : own_) {
      if (other.body != own.body || !tethers_.contains(other.tether)) continue;
      sum.add(other.limited);
      ++count;
    }
    SpringLimits::apply(limits_.share_of(own.body, sum), def);
    // Extrapolated by its velocity between two moves.
    def.anchor_w = own.def.anchor_w + std::max(since, 0.0) * own.velocity();
    def.anchor_velocity = own.velocity();
    limits_.slow(world_, dt, count, def);
    tethers_.set(world_, own.tether, def);
  }
}

pbd::Tether::Def Springs::pull_at(const Remote& remote, SessionTime time) const {
  pbd::Tether::Def def = remote.def;
  SpringLimits::apply(remote.share, def);
  const HandTrack& hand = remote.hand;
  if (time > hand.newest()) {
    carry_on(hand.motion(), seconds(time - hand.newest()), def);
  } else {
    const HandTrack::Place then = hand.at(time);
    def.anchor_w = then.position;
    def.anchor_velocity = then.velocity;
  }
  return def;
}

void Springs::carry_on(const HandFilter::Motion& hand, double age, pbd::Tether::Def& def) const {
  const HandFilter::Motion then = hand.after(std::min(age, options_.max_anchor_extrapolation));
  def.anchor_w = then.position;
  def.anchor_velocity = then.velocity;
  // Beyond the limit the anchor stands still: the hand of a lost user must not fly away.
  if (age >= options_.max_anchor_extrapolation) def.anchor_velocity.setZero();
}

void Springs::others_at(const pbd::World& world, SessionTime time, double dt,
                        std::vector<pbd::Tether::Def>& out) const {
  for (const Remote& remote : remote_) {
    const bool over = !remote.live && time >= remote.ended;
    if (over || time < remote.began) continue;
    if (!world_.contains(remote.def.body) || !world.contains(remote.def.body)) continue;
    limits_.slow(world, dt, remote.together, out.emplace_back(pull_at(remote, time)));
  }
}

void Springs::pulls(std::vector<pbd::Tether::Def>& out) const {
  std::vector<pbd::ConstraintId> all;
  rows(all);
  for (const pbd::ConstraintId row : all) out.push_back(tethers_.def(row));
}

void Springs::rows(std::vector<pbd::ConstraintId>& out) const {
  for (const Own& own : own_) {
    if (tethers_.contains(own.tether)) out.push_back(own.tether);
  }
  for (const Remote& remote : remote_) {
    if (pulls(remote)) out.push_back(remote.tether);
  }
}

void Springs::record(std::vector<Pull>& out) const {
  out.clear();
  for (const Own& own : own_) {
    if (tethers_.contains(own.tether)) out.push_back({tethers_.def(own.tether), own.told.motion()});
  }
}

void Springs::announce(SessionTime now, std::vector<SpringUpdate>& states,
                       std::vector<SpringUpdate>& events) {
  events.insert(events.end(), pending_.begin(), pending_.end());
  pending_.clear();
  for (Own& own : own_) {
    if (own.mode != InputMode::Soft) continue;
    own.told.add(own.moved != 0 ? own.moved : now, own.def.anchor_w, own.velocity());
    if (!own.announced) {
      events.push_back(own.message(SpringEvent::Create, now));
      own.announced = true;
    } else {
      states.push_back(own.message(SpringEvent::Change, now));
    }
  }
}

bool Springs::holds(pbd::BodyId body) const {
  const auto mine = [&](const Own& own) { return own.body == body && holds(own); };
  const auto theirs = [&](const Remote& r) { return pulls(r) && r.def.body == body; };
  return ranges::any_of(own_, mine) || ranges::any_of(remote_, theirs);
}

void Springs::held(PeerId self, std::vector<HeldBody>& out) const {
  for (const Own& own : own_) out.push_back({self, own.body, own.def.anchor_w});
  for (const Remote& remote : remote_) {
    if (pulls(remote)) out.push_back({remote.peer, remote.def.body, remote.def.anchor_w});
  }
}

void Springs::mark(std::vector<std::uint8_t>& grips) const {
  const auto set = [&](pbd::BodyId body, Grip grip) {
    if (world_.contains(body)) grips[body.index] |= grip;
  };
  for (const Own& own : own_) {
    if (holds(own)) set(own.body, own.mode == InputMode::Soft ? kShared : kAlone);
  }
  for (const Remote& remote : remote_) {
    if (pulls(remote)) set(remote.def.body, kRemote);
  }
}

int Springs::held_by(PeerId peer, pbd::BodyId body) {
  const auto holds = [&](const Remote& r) { return pulls(r) && r.def.body == body; };
  const std::span<Remote> all = of(peer);
  return static_cast<int>(std::count_if(all.begin(), all.end(), holds));
}

bool Springs::holds_alone(pbd::BodyId body) const {
  return std::any_of(own_.begin(), own_.end(),
                     [&](const Own& o) { return o.mode != InputMode::Soft && o.body == body; });
}

void Springs::hands(pbd::BodyId body, SessionTime now, std::vector<Hand>& out) const {
  for (const Own& own : own_) {
    if (own.mode != InputMode::Hard || own.body != body) continue;
    const double since = own.moved != 0 ? seconds(now - own.moved) : 0.0;
    const double ahead = since > kStill ? 0.0 : std::max(since, 0.0);
    out.push_back({own.def.attachment_l, own.def.anchor_w + ahead * own.velocity()});
  }
}

}  // namespace tandem::consensus
