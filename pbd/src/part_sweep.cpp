// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "part_sweep.h"

namespace tandem::pbd {

void PartSweep::start(std::span<const std::uint32_t> begins) {
  parts_.clear();
  for (std::size_t p = 0; p + 1 < begins.size(); ++p) parts_.push_back({begins[p], begins[p + 1]});
  need_of_.assign(begins.back(), kNone);
  need_.clear();
}

PartSweep::Needs PartSweep::needs(std::uint32_t block) {
  std::uint32_t& row = need_of_[block];
  const std::size_t size = std::size_t{2} * parts();
  if (row == kNone) {
    row = static_cast<std::uint32_t>(need_.size() / size);
    need_.resize(need_.size() + parts(), 0);
    need_.resize(need_.size() + parts(), kNone);
  }
  std::uint32_t* first = need_.data() + row * size;
  return {first, first + parts()};
}

void PartSweep::link(std::uint32_t earlier, std::uint32_t earlier_part, std::uint32_t later,
                     std::uint32_t later_part) {
  std::uint32_t& from = needs(later).forwards[earlier_part];
  from = std::max(from, earlier + 1);
  std::uint32_t& back = needs(earlier).back[later_part];
  back = std::min(back, later);
}

}  // namespace tandem::pbd
