// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "plaza/custody.h"

#include <algorithm>
#include <cmath>

#include "tandem/net/clock.h"

namespace tandem::demos {

namespace {

constexpr double kSlow = 0.02;            // m/s and rad/s
constexpr double kStill = 0.5;            // s
constexpr double kMoved = 0.02;           // m, from its record
constexpr double kApart = 0.5;            // m, more than agreeing copies differ
constexpr double kNobodyKeeps = 1.0;      // s, before an orphaned body is taken over
constexpr double kFresh = 0.5;            // s
constexpr double kLease = 1.0;            // s
constexpr double kLapsed = 3.0 * kLease;  // s
constexpr double kFast = 8.0;             // m/s, bound on a body's speed since its record
constexpr double kFarAway = 2.0;          // in reach(): farther bodies are left to others

double flat(const pbd::Vec3& a, const pbd::Vec3& b) { return (a - b).head<2>().norm(); }

}  // namespace

Custody::Custody(const PlazaOptions& options, consensus::PeerId self, tandem::Scene& scene,
                 consensus::Peer& peer, nats::BodyLedger& ledger)
    : options_(options),
      cells_(options.cells()),
      self_(self),
      scene_(scene),
      peer_(peer),
      ledger_(ledger) {}

void Custody::watch_cells(const pbd::Vec3& feet) {
  constexpr double kStride = 0.05;  // m
  if (watched_about_ && (*watched_about_ - feet).norm() < kStride) return;
  watched_about_ = feet;
  const double reach = options_.reach();
  for (auto at = watched_.begin(); at != watched_.end();) {
    if (nats::distance_to(cells_, *at, feet) <= reach + 2.0 * cells_.slack) {
      ++at;
      continue;
    }
    ledger_.unwatch(*at);
    std::erase_if(lying_, [&](const auto& entry) { return entry.second.record.cell == *at; });
    at = watched_.erase(at);
  }
  const pbd::Vec3 corner(reach, reach, 0.0);
  const nats::Cell low = nats::cell_at(cells_, feet - corner);
  const nats::Cell high = nats::cell_at(cells_, feet + corner);
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      if (watched_.insert({0, x, y}).second) ledger_.watch({0, x, y});
    }
  }
}

void Custody::appear(std::size_t number, const pbd::Pose& pose, const pbd::Twist& twist) {
  const pbd::BodyId body = scene_.add(PlazaBody::shape(number), {.mass = PlazaBody::kMass,
                                                                 .pose = pose,
                                                                 .twist = twist,
                                                                 .linear_damping = 0.1,
                                                                 .angular_damping = 1.0,
                                                                 .stable_id = number + 1});
  const consensus::SharedId id = PlazaBody::id(number);
  peer_.share({.id = id, .body = body});
  local_[id] = {.number = number, .body = body};
  ++counters_.appeared;
}

void Custody::hear(const nats::LedgerNews& news, consensus::SessionTime now) {
  const nats::LedgerRecord& record = news.record;
  const bool written = news.kind == nats::LedgerNews::Kind::Written;
  if (written) ++counters_.written;
  if (news.kind == nats::LedgerNews::Kind::Refused) ++counters_.refused;
  const auto before = lying_.find(record.id);
  if (written && before != lying_.end() && before->second.record.cell != record.cell) {
    ++counters_.crossings;
  }
  lying_[record.id] = {record, now};
  const auto local = local_.find(record.id);
  if (!written && local != local_.end()) settle(local, record);
}

void Custody::settle(std::map<consensus::SharedId, Local>::iterator local,
                     const nats::LedgerRecord& record) {
  const auto& [id, copy] = *local;
  const double apart = (scene_.world().pose(copy.body).position - record.pose.position).norm();
  if (apart <= kMoved || (held_ && *held_ == id)) return;
  const bool heard = std::ranges::any_of(
      near_, [&, id = id](consensus::PeerId peer) { return peer_.heard(id, peer).has_value(); });
  // The copies converge by themselves.
  if ((heard && apart < kApart) || peer_.heard(id, record.keeper)) return;
  // A remote peer has it: this copy is out of date.
  if (record.keeper != 0 ? apart < kApart : heard && apart < options_.reach()) return;
  vanish(local);
}

void Custody::vanish(std::map<consensus::SharedId, Local>::iterator local) {
  peer_.unshare(local->first);
  scene_.remove(local->second.body);
  ++counters_.vanished;
  local_.erase(local);
}

bool Custody::is_leased(const Lying& lying, consensus::SessionTime now) const {
  return net::seconds(now - std::max(lying.heard, served_since_)) < kLapsed;
}

bool Custody::is_kept(const nats::LedgerRecord& record, consensus::SessionTime now) const {
  if (record.keeper == 0) return false;
  if (peer_.heard(record.id, record.keeper)) return true;
  const auto at = lying_.find(record.id);
  return at != lying_.end() && is_leased(at->second, now);
}

bool Custody::agrees(const consensus::UnknownState& state, consensus::SessionTime now) const {
  const auto at = lying_.find(state.update.id);
  if (at == lying_.end()) return true;
  const auto& [record, heard] = at->second;
  if (record.keeper == 0 || record.keeper == state.from) return true;
  const double apart = (state.update.pose.position - record.pose.position).norm();
  return apart < kApart + kFast * net::seconds(now - heard);
}

consensus::PeerId Custody::successor(const consensus::SharedId& id,
                                     consensus::SessionTime now) const {
  consensus::PeerId out = self_;
  consensus::SessionTime latest = now - static_cast<consensus::SessionTime>(1e9 * kFresh);
  for (const consensus::PeerId peer : near_) {
    const auto heard = peer_.heard(id, peer);
    if (!heard || *heard <= latest) continue;
    latest = *heard;
    out = peer;
  }
  return out;
}

void Custody::begin(const pbd::Vec3& feet, std::span<const consensus::PeerId> near, bool served,
                    consensus::SessionTime now) {
  if (!served) served_since_ = now;
  near_.assign(near.begin(), near.end());
  watch_cells(feet);
  news_.clear();
  ledger_.take(news_);
  for (const nats::LedgerNews& news : news_) hear(news, now);
  // Neighbours' states first; a body that no neighbour has is where its record says.
  for (const consensus::UnknownState& state : peer_.unknown()) {
    const auto number = PlazaBody::number(state.update.id, options_.bodies);
    if (!number || local_.contains(state.update.id)) continue;
    if (flat(state.update.pose.position, feet) > options_.reach()) continue;
    if (!agrees(state, now)) continue;
    const double age = net::seconds(now - state.update.stamp);
    if (age < 0.0 || age > kFresh) continue;
    pbd::Pose pose = state.update.pose;
    if (!state.update.oriented) pose.orientation = pbd::Quat::Identity();
    appear(*number, pose, state.update.twist);
  }
  for (const auto& [id, lying] : lying_) {
    const auto number = PlazaBody::number(id, options_.bodies);
    if (!number || local_.contains(id)) continue;
    const nats::LedgerRecord& record = lying.record;
    // A kept body is in motion: its keeper announces it, or its resting place.
    const bool kept = record.keeper != 0 && record.keeper != self_;
    if (kept && (is_connected(record.keeper) || is_leased(lying, now))) continue;
    if (flat(record.pose.position, feet) > options_.reach()) continue;
    appear(*number, record.pose, {});
    // The keeper has gone.
    if (kept) ledger_.write(id, 0, record.pose, {});
  }
}

void Custody::keep(const consensus::SharedId& id, Local& local, bool held, const pbd::Vec3& feet,
                   consensus::SessionTime now) {
  const pbd::BodyState& state = scene_.world().state(local.body);
  const bool slow = state.twist.linear.norm() < kSlow && state.twist.angular.norm() < kSlow;
  if (!slow || held) local.still_since = 0;
  if (slow && !held && local.still_since == 0) local.still_since = now;
  const nats::LedgerRecord* const record = ledger_.known(id);
  if (record == nullptr) return;
  const bool still = local.still_since != 0 && net::seconds(now - local.still_since) > kStill;
  const bool moved = (state.pose.position - record->pose.position).norm() > kMoved;
  if (record->keeper == self_) {
    local.astray_since = 0;
    const bool crosses =
        nats::distance_to(cells_, record->cell, state.pose.position) > cells_.slack;
    const bool due = net::seconds(now - local.written_at) >= kLease;
    if (!still && !crosses && !due) return;
    // A peer near the body must continue it; this one will not hear of its contacts.
    const bool leaves =
        due && !held && flat(state.pose.position, feet) > options_.reach() + options_.slack();
    const consensus::PeerId keeper = still ? 0 : leaves ? successor(id, now) : self_;
    if (ledger_.write(id, keeper, state.pose, state.twist)) local.written_at = now;
    return;
  }
  if (held && !(record->keeper != 0 && peer_.heard(id, record->keeper))) {
    if (ledger_.write(id, self_, state.pose, state.twist)) local.written_at = now;
    return;
  }
  // It is not where its record says, and the peer that should write the record does not.
  if (is_kept(*record, now) || !moved) {
    local.astray_since = 0;
  } else if (local.astray_since == 0) {
    local.astray_since = now + static_cast<consensus::SessionTime>(self_ % 16) * 100'000'000;
  } else if (net::seconds(now - local.astray_since) > kNobodyKeeps) {
    local.astray_since = 0;
    ledger_.write(id, still ? 0 : self_, state.pose, state.twist);
  }
}

bool Custody::may_go(const consensus::SharedId& id, const Local& local, const pbd::Vec3& feet,
                     consensus::SessionTime now) const {
  const pbd::Vec3& position = scene_.world().pose(local.body).position;
  const double apart = flat(position, feet);
  if (apart <= options_.reach() + options_.slack()) return false;
  const nats::LedgerRecord* const record = ledger_.known(id);
  if (record == nullptr || record->keeper == self_) return false;
  if (apart > kFarAway * options_.reach()) return true;
  // A moved body stays here until it has a keeper or rests at its record.
  return is_kept(*record, now) || (position - record->pose.position).norm() <= kMoved;
}

void Custody::finish(const pbd::Vec3& feet, const consensus::SharedId* held,
                     consensus::SessionTime now) {
  held_ = held != nullptr ? std::optional(*held) : std::nullopt;
  for (auto at = local_.begin(); at != local_.end();) {
    auto& [id, local] = *at;
    const bool mine = held != nullptr && *held == id;
    keep(id, local, mine, feet, now);
    if (mine || !may_go(id, local, feet, now)) {
      ++at;
      continue;
    }
    vanish(at++);
  }
}

void Custody::leave() {
  for (const auto& [id, local] : local_) {
    const nats::LedgerRecord* const record = ledger_.known(id);
    if (record == nullptr || record->keeper != self_) continue;
    const pbd::BodyState& state = scene_.world().state(local.body);
    pbd::Pose pose = state.pose;
    pose.position.z() = std::max(pose.position.z(), PlazaBody::kHalf);
    ledger_.write(id, 0, pose, {});
  }
}

}  // namespace tandem::demos
