// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_order.h"

#include <algorithm>

namespace tandem::pbd {
namespace {

/// Blocks below which sharing a level out costs more than it saves.
constexpr std::uint32_t kWide = 4;

/// Kinds of rows in a level: of one point, and faces.
constexpr std::uint32_t kKinds = 2;

constexpr std::uint32_t kBlock = kLanes;

}  // namespace

void ContactOrder::build(std::span<const Contact> contacts, std::span<const std::uint32_t> sequence,
                         std::span<const SolverBody> bodies) {
  level_of_body_.assign(bodies.size(), 0);
  slot_of_contact_.resize(contacts.size());
  level_count_.clear();
  // Levels: one above the rows before that share a body.
  for (const std::uint32_t i : sequence) {
    const std::uint32_t group = group_of(contacts[i], bodies);
    const std::uint32_t a = contacts[i].manifold.body_a;
    const std::uint32_t b = contacts[i].manifold.body_b;
    const bool moves_a = bodies[a].inv_mass > 0.0;
    const bool moves_b = bodies[b].inv_mass > 0.0;
    const std::uint32_t level =
        std::max(moves_a ? level_of_body_[a] : 0, moves_b ? level_of_body_[b] : 0);
    if (moves_a) level_of_body_[a] = level + 1;
    if (moves_b) level_of_body_[b] = level + 1;
    slot_of_contact_[i] = level;
    if (group >= level_count_.size()) level_count_.resize(group + 1, 0);
    level_count_[group] = std::max(level_count_[group], level + 1);
  }
  // Counting sort by group, level and kind; equal ones stay in sequence.
  first_level_.assign(level_count_.size() + 1, 0);
  for (std::size_t g = 0; g < level_count_.size(); ++g) {
    first_level_[g + 1] = first_level_[g] + level_count_[g];
  }
  starts_.assign(kKinds * first_level_.back() + 1, 0);
  for (const std::uint32_t i : sequence) {
    const std::uint32_t level = slot_of_contact_[i] + first_level_[group_of(contacts[i], bodies)];
    slot_of_contact_[i] = kKinds * level + (contacts[i].manifold.count > 1 ? 1 : 0);
    ++starts_[slot_of_contact_[i] + 1];
  }
  for (std::size_t s = 1; s < starts_.size(); ++s) {
    starts_[s] = starts_[s - 1] + (starts_[s] + kBlock - 1) / kBlock * kBlock;
  }
  places_.assign(starts_.back(), kNone);
  groups_.clear();
  runs_.clear();
  const auto block_of = [&](std::uint32_t level) { return starts_[kKinds * level] / kBlock; };
  for (std::size_t g = 0; g < level_count_.size(); ++g) {
    Group group{.begin = block_of(first_level_[g]),
                .end = block_of(first_level_[g + 1]),
                .first_run = static_cast<std::uint32_t>(runs_.size())};
    for (std::uint32_t level = first_level_[g]; level < first_level_[g + 1]; ++level) {
      add_run(block_of(level), block_of(level + 1), group);
    }
    group.last_run = static_cast<std::uint32_t>(runs_.size());
    groups_.push_back(group);
  }
  for (const std::uint32_t i : sequence) places_[starts_[slot_of_contact_[i]]++] = i;
}

void ContactOrder::add_run(std::uint32_t begin, std::uint32_t end, Group& group) {
  const bool wide = end - begin >= kWide;
  group.wide = group.wide || wide;
  const bool continues =
      !wide && runs_.size() > group.first_run && !runs_.back().wide && runs_.back().end == begin;
  if (continues) {
    runs_.back().end = end;
  } else {
    runs_.push_back({begin, end, wide});
  }
}

}  // namespace tandem::pbd
