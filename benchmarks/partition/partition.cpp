// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "partition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "tandem/pbd/math.h"
#include "tandem/pbd/validate.h"

namespace tandem::partition_bench {

using pbd::detail::require;

namespace {

consensus::SessionTime to_ns(double seconds) {
  return static_cast<consensus::SessionTime>(std::llround(1e9 * seconds));
}

/// Index of a peer's cell. @throws std::invalid_argument where there is not one
std::size_t cell_of(std::span<const PartitionCell> cells, consensus::PeerId peer) {
  std::size_t found = cells.size();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].peer == 0 || (cells[i].peer == peer && found != cells.size())) {
      pbd::detail::refuse("Partition: cells[" + std::to_string(i) + "].peer",
                          "above 0, one cell for each", std::to_string(cells[i].peer));
    }
    if (cells[i].peer == peer) found = i;
  }
  if (found == cells.size()) {
    pbd::detail::refuse("Partition: self", "a peer that has a cell", std::to_string(peer));
  }
  return found;
}

}  // namespace

void PartitionOptions::validate() const {
  const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  require(positive(overlap), "PartitionOptions", "overlap", overlap, "finite and above 0 m");
  require(positive(reach), "PartitionOptions", "reach", reach, "finite and above 0 m");
  require(slack >= 0.0 && slack <= overlap, "PartitionOptions", "slack", slack,
          "0 m to the overlap");
  require(positive(patience) && patience <= 1e8, "PartitionOptions", "patience", patience,
          "above 0 to 1e8 s");
}

Partition::Partition(pbd::World& world, consensus::Peer& peer, PartitionBodies& bodies,
                     consensus::PeerId self, std::vector<PartitionCell> cells,
                     const PartitionOptions& options)
    : world_(world), peer_(peer), bodies_(bodies), self_(self), options_(options) {
  options.validate();
  set_cells(std::move(cells));
  peer_.set_interest(this);
}

Partition::~Partition() { peer_.set_interest(nullptr); }

void Partition::set_cells(std::vector<PartitionCell> cells) {
  own_cell_ = cell_of(cells, self_);
  cells_ = std::move(cells);
}

void Partition::add(const consensus::SharedId& id, pbd::BodyId body) {
  peer_.share({.id = id, .body = body});
  const auto at = members_.begin() + place_of(id);
  Member& member = *members_.insert(at, Member{.id = id, .body = body});
  const double depth = own_depth(world_.pose(body).position);
  if (depth < -(options_.overlap + options_.reach)) {
    peer_.unshare(id);
    bodies_.vanish(id, body);
    members_.erase(members_.begin() + (&member - members_.data()));
    return;
  }
  set_side(member, true, 0);
}

void Partition::update(consensus::SessionTime now) {
  updated_ = now;
  take_in(now);
  stats_.own = stats_.common = stats_.followed = 0;
  const double far = options_.overlap + options_.reach + options_.slack;
  const auto patience = to_ns(options_.patience);
  std::erase_if(members_, [&](Member& member) {
    if (!world_.contains(member.body)) {  // the application's doing
      peer_.unshare(member.id);
      return true;
    }
    const pbd::Vec3& position = world_.pose(member.body).position;
    // A copy of which the owner says nothing any more is far away. Of the others nobody lets go of
    // what nobody else has.
    const bool far_away = own_depth(position) < -far && is_fresh(member, peer_at(position), now);
    if (member.since == 0) member.since = now;
    const bool silent = member.since <= now - patience && !is_fresh(member, member.owner, now);
    const bool gone = far_away || (member.side == Side::Followed && silent);
    if (gone) {
      peer_.unshare(member.id);
      bodies_.vanish(member.id, member.body);
      ++stats_.vanished;
      return true;
    }
    set_side(member, false, now);
    switch (member.side) {
      case Side::Own:
        ++stats_.own;
        break;
      case Side::Common:
        ++stats_.common;
        break;
      case Side::Followed:
        ++stats_.followed;
        break;
    }
    return false;
  });
}

std::ptrdiff_t Partition::place_of(const consensus::SharedId& id) const {
  return std::ranges::lower_bound(members_, id, {}, &Member::id) - members_.begin();
}

bool Partition::is_fresh(const Member& member, consensus::PeerId from,
                         consensus::SessionTime now) const {
  const auto heard = peer_.heard(member.id, from);
  return heard.has_value() && *heard > now - to_ns(options_.patience);
}

void Partition::set_side(Member& member, bool comes, consensus::SessionTime now) {
  const pbd::Vec3& position = world_.pose(member.body).position;
  const double depth = own_depth(position);
  const double in = member.side == Side::Own ? options_.overlap - options_.slack : options_.overlap;
  const double out =
      member.side == Side::Followed ? options_.overlap - options_.slack : options_.overlap;
  Side side = depth > in ? Side::Own : depth < -out ? Side::Followed : Side::Common;
  consensus::PeerId owner = 0;
  if (side == Side::Followed) {
    owner = peer_at(position);
    // What came as somebody's is believed to be; what was here goes to nobody who says nothing.
    if (!comes && !is_fresh(member, owner, now)) {
      side = member.side == Side::Followed ? Side::Followed : Side::Common;
      owner = member.owner;
    }
  }
  if (side == member.side && (side != Side::Followed || owner == member.owner)) return;
  member.side = side;
  member.owner = owner;
  switch (side) {
    case Side::Own:
      peer_.set_owner(member.id, self_);
      break;
    case Side::Common:
      peer_.set_owner(member.id, std::nullopt);
      break;
    case Side::Followed:
      peer_.set_owner(member.id, owner);
      break;
  }
}

/// Bodies that others tell of and that are not here.
void Partition::take_in(consensus::SessionTime now) {
  for (const consensus::UnknownState& unknown : peer_.unknown()) {
    // Who has no cell decides on nothing.
    if (std::ranges::find(cells_, unknown.from, &PartitionCell::peer) == cells_.end()) continue;
    const consensus::StateUpdate& update = unknown.update;
    const double age = 1e-9 * static_cast<double>(now - update.stamp);
    if (age < 0.0 || age > options_.patience) continue;
    pbd::Pose pose = update.pose;
    pbd::Twist twist = update.twist;
    pose.position += age * twist.linear;
    const bool free = !update.flags.in_contact && !update.flags.held && !update.flags.owner_driven;
    if (free) {
      pose.position += 0.5 * age * age * world_.gravity();
      twist.linear += age * world_.gravity();
    }
    pose.orientation = pbd::rotated(pose.orientation, age * update.twist.angular);
    if (own_depth(pose.position) < -(options_.overlap + options_.reach)) continue;
    const auto at = members_.begin() + place_of(update.id);
    if (at != members_.end() && at->id == update.id) continue;  // told of by two peers
    const pbd::BodyId body = bodies_.appear(update.id, pose, twist);
    if (!body.valid()) continue;
    Member& member = *members_.insert(at, Member{.id = update.id, .body = body, .since = now});
    peer_.share({.id = update.id, .body = body});
    set_side(member, true, now);
    ++stats_.appeared;
  }
}

bool Partition::concerns(consensus::PeerId to, const consensus::SharedId& id,
                         const pbd::Pose& pose) const {
  const auto at = members_.begin() + place_of(id);
  if (at == members_.end() || at->id != id) return true;
  if (at->side == Side::Followed) return false;
  for (const PartitionCell& cell : cells_) {
    if (cell.peer != to) continue;
    // Who speaks of it has it, wherever it is, and waits to hear that somebody else has.
    return depth_in(cell.cell, pose.position) > -(options_.overlap + options_.reach) ||
           is_fresh(*at, to, updated_);
  }
  return false;
}

consensus::PeerId Partition::peer_at(const pbd::Vec3& position) const {
  return cells_[cell_at(position)].peer;
}

std::size_t Partition::cell_at(const pbd::Vec3& position) const {
  std::size_t best = 0;
  double deepest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const double depth = depth_in(cells_[i].cell, position);
    if (depth > deepest) {
      deepest = depth;
      best = i;
    }
  }
  return best;
}

double Partition::own_depth(const pbd::Vec3& position) const {
  return depth_in(cells_[own_cell_].cell, position);
}

}  // namespace tandem::partition_bench
