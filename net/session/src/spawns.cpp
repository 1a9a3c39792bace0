// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "spawns.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <stdexcept>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

constexpr std::string_view kSpawn = "tandem.spawn";
constexpr std::string_view kDespawn = "tandem.despawn";
constexpr std::string_view kAsk = "tandem.ask";
constexpr std::string_view kTold = "tandem.told";

/// ns: a member may ask as often as it likes, but is answered at this interval.
constexpr SessionTime kAnswerEvery = 1'000'000'000;
constexpr std::size_t kIdsPerEvent = 32;
/// Prefix of the lower half of all ids by spawn(): the id of a name cannot be taken before the
/// application shares it.
constexpr std::uint64_t kMark = 0xb0d;
constexpr int kNumberBits = 52;

bool is_spawned(const SharedId& id) { return id.low >> kNumberBits == kMark; }

}  // namespace

void RemovedIds::add(const SharedId& id) {
  if (!known_.insert(id).second) return;
  order_.push_back(id);
  if (order_.size() <= kMaxIds) return;
  known_.erase(order_.front());
  order_.pop_front();
}

Spawns::Spawns(const SpawnOptions& options, pbd::World& world, consensus::Peer& peer,
               consensus::EventChannel& events)
    : options_(options), world_(world), peer_(peer), events_(events) {}

bool Spawns::has_room(const SharedId& id, std::size_t times) const {
  if (here_.size() / times >= options_.max_bodies) return false;
  const auto first = here_.lower_bound({.high = id.high, .low = 0});
  const auto last = here_.upper_bound({.high = id.high, .low = UINT64_MAX});
  return static_cast<std::size_t>(std::distance(first, last)) / times < options_.max_of_one;
}

SharedId Spawns::spawn(std::string_view what, const pbd::Pose& pose, const pbd::Twist& twist,
                       SessionTime now) {
  // By the time, so that a member restarted under its id repeats none.
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kNumberBits) - 1;
  const std::uint64_t number = std::max(static_cast<std::uint64_t>(now) / 1000 & kMask, last_ + 1);
  const SharedId id{.high = events_.self(), .low = kMark << kNumberBits | number};
  const consensus::StateUpdate state{.id = id, .pose = pose, .twist = twist, .stamp = now};
  if (const consensus::CodecResult checked = consensus::check(state); !checked.ok()) {
    throw std::invalid_argument(std::string("Session::spawn: ") + checked.detail);
  }
  if (what.size() > SpawnOptions::kMaxBytes) {
    pbd::detail::refuse("Session::spawn: bytes of `what`", "at most SpawnOptions::kMaxBytes",
                        static_cast<double>(what.size()));
  }
  if (!has_room(id, 1)) {
    pbd::detail::refuse("Session::spawn: number of bodies",
                        "below SpawnOptions' max_bodies in all and max_of_one of a member");
  }
  last_ = number;
  add(state, what);
  try {
    tell(id, here_.at(id), consensus::EventChannel::kToAll);
  } catch (...) {
    forget(id);
    throw;
  }
  return id;
}

void Spawns::despawn(const SharedId& id) {
  if (!here_.contains(id)) {
    pbd::detail::refuse("Session::despawn: id", "of a body that a member has spawned",
                        id.to_string());
  }
  tell_removed({&id, 1}, consensus::EventChannel::kToAll);
  forget(id);
}

void Spawns::join(PeerId member) {
  members_[member] = {};
  events_.send(kAsk, {}, member);
}

void Spawns::receive(SessionTime now) {
  std::exception_ptr failed;  // in the application: the remaining events are processed all the same
  for (const consensus::Event& event : events_.received()) {
    try {
      hear(event);
    } catch (...) {
      if (!failed) failed = std::current_exception();
    }
  }
  for (auto& [id, member] : members_) {
    const bool lately =
        member.answered != 0 && now >= member.answered && now - member.answered < kAnswerEvery;
    if (!member.asks || lately) continue;
    member.asks = false;
    member.answered = now;
    tell_all(id);
  }
  if (failed) std::rethrow_exception(failed);
}

void Spawns::hear(const consensus::Event& event) {
  const auto member = members_.find(event.from);
  if (event.topic == kAsk) {
    if (member != members_.end()) member->second.asks = true;
  } else if (event.topic == kTold) {
    if (member != members_.end()) member->second.told = true;
  } else if (event.topic == kSpawn) {
    refused_ += hear_spawn(event) ? 0 : 1;
  } else if (event.topic == kDespawn) {
    refused_ += hear_despawn(event) ? 0 : 1;
  }
}

bool Spawns::hear_spawn(const consensus::Event& event) {
  constexpr std::size_t kState = consensus::kHeaderBytes + consensus::kStateBytes;
  const std::size_t size = event.payload.size();
  if (size < kState || size > kState + SpawnOptions::kMaxBytes) return false;
  if (event.role == consensus::Role::Watch) return false;
  const std::span<const std::byte> payload(event.payload);
  if (!consensus::decode(payload.first(kState), packet_).ok()) return false;
  if (packet_.states.size() != 1) return false;
  const consensus::StateUpdate& state = packet_.states.front();
  if (!is_spawned(state.id)) return false;
  if (here_.contains(state.id)) return true;  // all members send it to a newcomer
  if (removed_.contains(state.id) || unknown_.contains(state.id)) {
    if (state.id.high == event.from) tell_removed({&state.id, 1}, event.from);
    return true;
  }
  const auto member = members_.find(event.from);
  const bool tells_all = member != members_.end() && !member->second.told;
  if (state.id.high != event.from && !tells_all) return false;
  // Each member applies the limits to what it knows: members that spawn at the same time exceed
  // them.
  if (!has_room(state.id, 2)) return false;
  const std::span<const std::byte> what = payload.subspan(kState);
  try {
    add(state, {reinterpret_cast<const char*>(what.data()), what.size()});
  } catch (const std::invalid_argument&) {  // `make` does not know `what`
    return false;
  } catch (...) {  // `make` fails: the application gets the exception
    ++refused_;
    throw;
  }
  return true;
}

bool Spawns::hear_despawn(const consensus::Event& event) {
  if (event.role == consensus::Role::Watch) return false;
  pbd::ByteReader in(event.payload);
  while (in.remaining() > 0) {
    const std::uint64_t high = in.u64();
    const SharedId id{.high = high, .low = in.u64()};
    if (in.failed() || !is_spawned(id)) return false;
    forget(id);
  }
  return true;
}

void Spawns::tell_all(PeerId member) {
  const std::vector<SharedId> removed(removed_.in_order().begin(), removed_.in_order().end());
  for (std::size_t i = 0; i < removed.size(); i += kIdsPerEvent) {
    const std::size_t count = std::min(kIdsPerEvent, removed.size() - i);
    tell_removed(std::span(removed).subspan(i, count), member);
  }
  for (const auto& [id, here] : here_) tell(id, here, member);
  events_.send(kTold, {}, member);
}

void Spawns::tell(const SharedId& id, const Here& here, PeerId to) {
  if (!world_.contains(here.body)) return;  // the application has removed it itself
  const consensus::StateUpdate state{
      .id = id, .pose = world_.pose(here.body), .twist = world_.twist(here.body)};
  bytes_.clear();
  if (consensus::encode({&state, 1}, bytes_) == 0) return;  // beyond the range of positions
  const auto what = std::as_bytes(std::span(here.what));
  bytes_.insert(bytes_.end(), what.begin(), what.end());
  events_.send(kSpawn, bytes_, to);
}

void Spawns::tell_removed(std::span<const SharedId> ids, PeerId to) {
  bytes_.clear();
  pbd::ByteWriter out(bytes_);
  for (const SharedId& id : ids) {
    out.u64(id.high);
    out.u64(id.low);
  }
  events_.send(kDespawn, bytes_, to);
}

void Spawns::add(const consensus::StateUpdate& state, std::string_view what) {
  const pbd::BodyId body = options_.make(what);
  if (!world_.contains(body)) pbd::detail::refuse("SpawnOptions::make", "a body of the world");
  try {
    world_.set_pose(body, state.pose);
    world_.set_twist(body, state.twist);
    peer_.share({.id = state.id, .body = body});
  } catch (...) {
    options_.remove(body);
    throw;
  }
  here_[state.id] = {body, std::string(what)};
}

void Spawns::forget(const SharedId& id) {
  const auto here = here_.extract(id);
  if (!here) {
    if (!removed_.contains(id)) unknown_.add(id);
    return;
  }
  removed_.add(id);
  if (peer_.body_of(id) != pbd::BodyId{}) peer_.unshare(id);
  if (world_.contains(here.mapped().body)) options_.remove(here.mapped().body);
}

}  // namespace tandem
