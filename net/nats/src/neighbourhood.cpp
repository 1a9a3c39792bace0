// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "neighbourhood.h"

#include <algorithm>
#include <cmath>

namespace tandem::nats {

namespace {

constexpr double kEnoughOfSlack = 0.05;  // part of slack that a user moves before cells are updated

}  // namespace

void Neighbourhood::hear(PeerId peer, const Presence& presence, std::int64_t now) {
  if (peer == self_ || peer == 0) return;
  const auto known = contacts_.find(peer);
  if (known == contacts_.end() && contacts_.size() >= kMaxContacts) {
    const auto farthest = std::ranges::max_element(
        contacts_, {}, [this](const auto& entry) { return distance(entry.second); });
    const Contact comer{presence.position, presence.hears, now, false};
    if (farthest->second.met || distance(farthest->second) <= distance(comer)) return;
    contacts_.erase(farthest);
  }
  Contact& contact = contacts_[peer];
  contact.position = presence.position;
  contact.hears = presence.hears;
  contact.heard = now;
}

void Neighbourhood::lower_limit() {
  limit_ = std::max(options_.min_near, limit_ - std::max<std::size_t>(1, limit_ / 4));
}

void Neighbourhood::raise_limit() { limit_ = std::min(options_.max_near, limit_ + 1); }

std::size_t Neighbourhood::people_in(const Cell& cell) const {
  const bool self = cell_at(options_, position_, cell.level) == cell;
  const auto others = std::ranges::count_if(contacts_, [&](const auto& entry) {
    return cell_at(options_, entry.second.position, cell.level) == cell;
  });
  return static_cast<std::size_t>(others) + (self ? 1 : 0);
}

const Neighbourhood::Changes& Neighbourhood::update(bool served, std::int64_t now) {
  changes_ = {};
  update_cells();
  update_hears();
  update_peers(served, now);
  return changes_;
}

void Neighbourhood::update_hears() {
  distances_.clear();
  for (const auto& [peer, contact] : contacts_) {
    const double apart = distance(contact);
    if (apart <= options_.near + options_.slack) distances_.push_back(apart);
  }
  double want = options_.near;
  if (distances_.size() > limit_) {
    const auto last = distances_.begin() + static_cast<std::ptrdiff_t>(limit_) - 1;
    const auto next = last + 1;
    std::nth_element(distances_.begin(), last, distances_.end());
    // Half way to the first peer that is no longer heard.
    want = std::min(want, 0.5 * (*last + *std::min_element(next, distances_.end())));
  }
  // Small changes are ignored: peers that come and go at the edge end nothing.
  if (want < hears_ - 0.5 * options_.slack || want > hears_ + 0.5 * options_.slack ||
      want == options_.near) {
    hears_ = want;
  }
}

void Neighbourhood::update_peers(bool served, std::int64_t now) {
  met_.clear();
  for (auto at = contacts_.begin(); at != contacts_.end();) {
    Contact& contact = at->second;
    const double apart = distance(contact);
    const double most = std::min(hears_, contact.hears);
    if (!served) contact.heard = now;
    const bool silent = now - contact.heard > kForget;
    if (!contact.met && !silent && apart <= most) {
      contact.met = true;
      changes_.meet.push_back(at->first);
    } else if (contact.met && (silent || apart > most + options_.slack)) {
      contact.met = false;
      changes_.part.push_back(at->first);
    }
    if (contact.met) met_.push_back({at->first, contact.position});
    at = silent ? contacts_.erase(at) : std::next(at);
  }
}

void Neighbourhood::update_cells() {
  const double enough = kEnoughOfSlack * options_.slack;
  if (cells_about_ && (*cells_about_ - position_).norm() < enough) return;
  cells_about_ = position_;
  for (auto at = cells_.begin(); at != cells_.end();) {
    const double reach = at->level == 0 ? options_.near + 3.0 * options_.slack
                                        : 1.1 * cell_edge(options_, at->level);
    if (distance_to(options_, *at, position_) <= reach) {
      ++at;
      continue;
    }
    changes_.unlisten.push_back(*at);
    at = cells_.erase(at);
  }
  // A peer that has moved too far is heard once more, and so parted from.
  want_around(0, options_.near + 2.0 * options_.slack);
  for (int level = 1; level < options_.levels; ++level) {
    want_around(level, cell_edge(options_, level));
  }
}

void Neighbourhood::want_around(int level, double radius) {
  const pbd::Vec3 corner(radius, radius, 0.0);
  const Cell low = cell_at(options_, position_ - corner, level);
  const Cell high = cell_at(options_, position_ + corner, level);
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      const Cell cell{level, x, y};
      if (cells_.insert(cell).second) changes_.listen.push_back(cell);
    }
  }
}

}  // namespace tandem::nats
