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

void ContactOrder::build(std::span<const ContactLink> sequence, std::size_t bodies) {
  level_of_body_.assign(bodies, 0);
  slots_.resize(sequence.size());
  level_count_.clear();
  // Levels: one above the rows before that share a body.
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const ContactLink& link = sequence[i];
    const std::uint32_t level = std::max(link.moves_a ? level_of_body_[link.a] : 0,
                                         link.moves_b ? level_of_body_[link.b] : 0);
    if (link.moves_a) level_of_body_[link.a] = level + 1;
    if (link.moves_b) level_of_body_[link.b] = level + 1;
    slots_[i] = level;
    if (link.group >= level_count_.size()) level_count_.resize(link.group + 1, 0);
    level_count_[link.group] = std::max(level_count_[link.group], level + 1);
  }
  // Counting sort by group, level and kind; equal ones stay in sequence.
  first_level_.assign(level_count_.size() + 1, 0);
  for (std::size_t g = 0; g < level_count_.size(); ++g) {
    first_level_[g + 1] = first_level_[g] + level_count_[g];
  }
  starts_.assign(kKinds * first_level_.back() + 1, 0);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const std::uint32_t level = slots_[i] + first_level_[sequence[i].group];
    slots_[i] = kKinds * level + (sequence[i].face ? 1 : 0);
    ++starts_[slots_[i] + 1];
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
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    places_[starts_[slots_[i]]++] = sequence[i].contact;
  }
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
