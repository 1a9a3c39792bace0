// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_order.h"

#include <algorithm>
#include <array>

namespace tandem::pbd {
namespace {

/// Kinds of rows in a level: single points, and faces.
constexpr std::uint32_t kKinds = 2;

constexpr std::uint32_t kBlock = kLanes;

/// Smallest mean number of contacts of a level in a part. In narrow levels a part waits for its
/// neighbours at each: a pyramid of base 100 (37 contacts a level) takes 1.4 times less time in 2
/// parts than in one, and no less in 4; a heap of 8000 cubes (93 a level) 2.4 times in 8, 2.6 in
/// 16.
constexpr std::uint32_t kWide = 14;

/// Calls visit(body) for the movable ends of a row.
void for_moving(const ContactLink& link, auto&& visit) {
  if (link.moves_a) visit(link.a);
  if (link.moves_b) visit(link.b);
}

std::uint32_t parts_of(std::uint32_t contacts, std::uint32_t levels, std::uint32_t workers) {
  if (contacts == 0) return 1;
  return std::clamp(contacts / (kWide * levels), 1u, std::min(workers, PartSweep::kMaxParts));
}

}  // namespace

void ContactOrder::build(std::span<const ContactLink> sequence, const ContactCells& cells,
                         std::size_t bodies, std::span<const std::uint32_t> movers,
                         std::uint32_t workers) {
  last_of_body_.resize(bodies);
  find_levels(sequence, movers);
  lay_out(sequence, cells);
  sweeps_used_ = 0;
  for (std::uint32_t g = 0; g < groups_.size(); ++g) {
    const std::uint32_t parts = parts_of(cells.contacts(g), groups_[g].levels, workers);
    if (parts > 1) divide(groups_[g], parts, sequence, cells);
  }
  for (std::uint32_t& place : places_) {
    if (place != kNone) place = sequence[place].contact;
  }
}

/// Level of a row: one above the earlier rows that share a body.
void ContactOrder::find_levels(std::span<const ContactLink> sequence,
                               std::span<const std::uint32_t> movers) {
  for (const std::uint32_t i : movers) last_of_body_[i] = 0;
  slots_.resize(sequence.size());
  groups_.clear();
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const ContactLink& link = sequence[i];
    std::uint32_t level = 0;
    for_moving(link, [&](std::uint32_t body) { level = std::max(level, last_of_body_[body]); });
    for_moving(link, [&](std::uint32_t body) { last_of_body_[body] = level + 1; });
    slots_[i] = level;
    if (link.group >= groups_.size()) groups_.resize(link.group + 1);
    Group& group = groups_[link.group];
    group.levels = std::max(group.levels, level + 1);
    ++group.rows;
  }
}

/// Counting sort by group, level and kind; ties by cell, then by sequence.
void ContactOrder::lay_out(std::span<const ContactLink> sequence, const ContactCells& cells) {
  std::uint32_t levels = 0;
  for (Group& group : groups_) {
    group.first_level = levels;
    levels += group.levels;
  }
  starts_.assign(std::size_t{kKinds} * levels + 1, 0);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const ContactLink& link = sequence[i];
    slots_[i] = kKinds * (groups_[link.group].first_level + slots_[i]) + (link.face ? 1 : 0);
    ++starts_[slots_[i] + 1];
  }
  for (std::size_t s = 1; s < starts_.size(); ++s) {
    starts_[s] = starts_[s - 1] + (starts_[s] + kBlock - 1) / kBlock * kBlock;
  }
  places_.assign(starts_.back(), kNone);
  first_blocks_.clear();
  for (std::uint32_t level = 0; level <= levels; ++level) {
    first_blocks_.push_back(starts_[std::size_t{kKinds} * level] / kBlock);
  }
  for (Group& group : groups_) {
    group.begin = first_blocks_[group.first_level];
    group.end = first_blocks_[group.first_level + group.levels];
  }
  const auto place = [&](std::uint32_t i) { places_[starts_[slots_[i]]++] = i; };
  if (cells.any()) {
    sort_by_cell(sequence, cells);
    for (const std::uint32_t i : by_cell_) place(i);
  } else {
    for (std::uint32_t i = 0; i < sequence.size(); ++i) place(i);
  }
}

void ContactOrder::sort_by_cell(std::span<const ContactLink> sequence, const ContactCells& cells) {
  std::array<std::uint32_t, ContactCells::kCells + 1> start{};
  for (const ContactLink& link : sequence) ++start[cells.of(link) + 1];
  for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  by_cell_.resize(sequence.size());
  for (std::uint32_t i = 0; i < sequence.size(); ++i) by_cell_[start[cells.of(sequence[i])]++] = i;
}

/// Stores the blocks of a part next to each other, by level. Within a level, blocks that share a
/// body with another part come first, so that neighbouring workers find them done.
void ContactOrder::divide(Group& group, std::uint32_t parts, std::span<const ContactLink> sequence,
                          const ContactCells& cells) {
  const std::uint32_t blocks = group.end - group.begin;
  const std::span<std::uint32_t> places =
      std::span(places_).subspan(kBlock * group.begin, kBlock * blocks);
  const std::vector<std::uint32_t>& before = by_level_places_;
  by_level_places_.assign(places.begin(), places.end());
  begins_.assign(parts + 1, 0);
  part_of_.resize(blocks);
  shares_.assign(blocks, 0);
  for (std::uint32_t k = 0; k < blocks; ++k) {
    const std::uint32_t cell = cells.of(sequence[before[kBlock * k]]);
    part_of_[k] = cell * parts / ContactCells::kCells;
    ++begins_[part_of_[k] + 1];
  }
  for (std::uint32_t p = 1; p <= parts; ++p) begins_[p] += begins_[p - 1];
  group.sweep = static_cast<std::uint32_t>(sweeps_used_++);
  if (sweeps_used_ > sweeps_.size()) sweeps_.emplace_back();
  PartSweep& sweep = sweeps_[group.sweep];
  sweep.start(begins_);
  for_neighbours(before, sequence, [&](std::uint32_t earlier, std::uint32_t later) {
    if (part_of_[earlier] != part_of_[later]) shares_[earlier] = shares_[later] = 1;
  });
  if (by_level_.size() < group.end) by_level_.resize(group.end);
  const std::span<std::uint32_t> by_level = std::span(by_level_).subspan(group.begin, blocks);
  for (std::uint32_t level = 0; level < group.levels; ++level) {
    const std::uint32_t first = first_block(group, level);
    const std::uint32_t last = first_block(group, level + 1);
    for (const bool shared : {true, false}) {
      for (std::uint32_t k = first; k < last; ++k) {
        if ((shares_[k] != 0) != shared) continue;
        by_level[k] = begins_[part_of_[k]]++;
        std::copy_n(before.begin() + kBlock * k, kBlock, places.begin() + kBlock * by_level[k]);
      }
    }
  }
  for_neighbours(before, sequence, [&](std::uint32_t earlier, std::uint32_t later) {
    if (part_of_[earlier] != part_of_[later])
      sweep.link(by_level[earlier], part_of_[earlier], by_level[later], part_of_[later]);
  });
}

/// Calls visit(earlier, later) for consecutive blocks of a body.
void ContactOrder::for_neighbours(std::span<const std::uint32_t> places,
                                  std::span<const ContactLink> sequence, auto&& visit) {
  for (const std::uint32_t place : places) {
    if (place == kNone) continue;
    for_moving(sequence[place], [&](std::uint32_t body) { last_of_body_[body] = kNone; });
  }
  for (std::uint32_t at = 0; at < places.size(); ++at) {
    if (places[at] == kNone) continue;
    const std::uint32_t block = at / kBlock;
    for_moving(sequence[places[at]], [&](std::uint32_t body) {
      if (last_of_body_[body] != kNone) visit(last_of_body_[body], block);
      last_of_body_[body] = block;
    });
  }
}

}  // namespace tandem::pbd
