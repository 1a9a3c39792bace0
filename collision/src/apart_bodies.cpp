// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "apart_bodies.h"

#include <algorithm>
#include <iterator>

namespace tandem::collision {
namespace {

bool is_ascending(std::span<const pbd::BodyPair> pairs) {
  for (const pbd::BodyPair& pair : pairs) {
    if (pair.low >= pair.high) return false;
  }
  const auto at = std::adjacent_find(pairs.begin(), pairs.end(),
                                     [](const auto& l, const auto& r) { return !(l < r); });
  return at == pairs.end();
}

void save_pairs(pbd::ByteWriter& out, std::span<const pbd::BodyPair> pairs) {
  out.u32(static_cast<std::uint32_t>(pairs.size()));
  for (const pbd::BodyPair& pair : pairs) {
    out.u32(pair.low);
    out.u32(pair.high);
  }
}

bool load_pairs(pbd::ByteReader& in, std::vector<pbd::BodyPair>& pairs) {
  pairs.clear();
  const std::uint32_t count = in.u32();
  for (std::uint32_t i = 0; i < count && !in.failed(); ++i) {
    const std::uint32_t low = in.u32();
    pairs.push_back({low, in.u32()});
  }
  return !in.failed() && is_ascending(pairs);
}

}  // namespace

bool ApartBodies::find(pbd::BodyPair pair) const {
  return std::binary_search(all_.begin(), all_.end(), pair);
}

bool ApartBodies::named(std::uint32_t a, std::uint32_t b) const {
  return std::binary_search(named_.begin(), named_.end(), pbd::BodyPair::of(a, b));
}

bool ApartBodies::name(pbd::BodyPair pair, bool apart) {
  const auto at = std::lower_bound(named_.begin(), named_.end(), pair);
  const bool before = at != named_.end() && *at == pair;
  if (before == apart) return false;
  if (apart) {
    named_.insert(at, pair);
  } else {
    named_.erase(at);
  }
  return true;
}

void ApartBodies::remove_body(std::uint32_t body) {
  std::erase_if(named_,
                [&](const pbd::BodyPair& pair) { return pair.low == body || pair.high == body; });
}

bool ApartBodies::renew(const pbd::World& world) {
  next_ = named_;
  for (const auto& block : world.blocks()) block->append_apart(next_);
  if (next_.empty() && all_.empty()) return false;
  std::sort(next_.begin(), next_.end());
  next_.erase(std::unique(next_.begin(), next_.end()), next_.end());
  if (next_ == all_) return false;
  changed_.clear();
  std::set_symmetric_difference(next_.begin(), next_.end(), all_.begin(), all_.end(),
                                std::back_inserter(changed_));
  all_.swap(next_);
  return true;
}

void ApartBodies::save(pbd::ByteWriter& out) const {
  save_pairs(out, named_);
  save_pairs(out, all_);
}

bool ApartBodies::load(pbd::ByteReader& in) {
  return load_pairs(in, named_) && load_pairs(in, all_);
}

}  // namespace tandem::collision
