// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agreement.h"

#include <algorithm>

namespace tandem::mpi {

std::uint32_t IslandAgreement::cut_island(std::uint32_t island) const {
  const auto at = std::lower_bound(
      own_cut_.begin(), own_cut_.end(), island,
      [](const auto& entry, std::uint32_t wanted) { return entry.first < wanted; });
  return at != own_cut_.end() && at->first == island ? at->second : kNone;
}

/// The solving rank tells the owner which of its bodies are touched, and their islands there.
void IslandAgreement::exchange_links(std::span<const std::uint32_t> island_of) {
  links_.clear();
  own_parts_.clear();
  for (const Neighbour& neighbour : neighbours_.all()) {
    if (!neighbour.solves) continue;
    MessageWriter out(ranks_.outgoing());
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < neighbour.bodies.size(); ++i) {
      if (next == neighbour.touched.size()) break;
      if (neighbour.bodies[i] != neighbour.touched[next]) continue;
      ++next;
      out.put(i);
      out.put(island_of[neighbour.bodies[i]]);
      own_parts_.push_back(island_of[neighbour.bodies[i]]);
    }
    ranks_.send(neighbour.rank, Topic::Links);
  }
  for (Neighbour& neighbour : neighbours_.all()) {
    if (neighbour.solves) continue;
    neighbour.touched.clear();
    MessageReader in = ranks_.receive(neighbour.rank, Topic::Links);
    while (in.remaining() > 0) {
      const auto i = in.get<std::uint32_t>();
      const auto island = in.get<std::uint32_t>();
      if (in.failed() || i >= neighbour.bodies.size()) {
        Environment::abort("another rank's message names a body that is not known");
      }
      const std::uint32_t slot = neighbour.bodies[i];
      neighbour.touched.push_back(slot);
      links_.emplace_back(island_of[slot], Node(neighbour.rank, island));
      own_parts_.push_back(island_of[slot]);
    }
  }
  std::sort(links_.begin(), links_.end());
  links_.erase(std::unique(links_.begin(), links_.end()), links_.end());
  std::sort(own_parts_.begin(), own_parts_.end());
  own_parts_.erase(std::unique(own_parts_.begin(), own_parts_.end()), own_parts_.end());
}

void IslandAgreement::gather_parts(std::span<const pbd::IslandPart> islands) {
  bytes_.clear();
  MessageWriter out(bytes_);
  out.put(static_cast<std::uint32_t>(own_parts_.size()));
  for (const std::uint32_t island : own_parts_) {
    out.put(island);
    out.put<std::uint8_t>(islands[island].awake ? 1 : 0);
    out.put(islands[island].level_sum);
    out.put(islands[island].bodies);
  }
  for (const auto& [island, other] : links_) {
    out.put(island);
    out.put(other.first);
    out.put(other.second);
  }
  parts_.clear();
  all_links_.clear();
  int rank = 0;
  for (MessageReader& in : ranks_.gather(bytes_)) {
    const auto count = in.get<std::uint32_t>();
    for (std::uint32_t k = 0; k < count && !in.failed(); ++k) {
      CutIsland part;
      const auto island = in.get<std::uint32_t>();
      part.awake = in.get<std::uint8_t>() != 0;
      part.level_sum = in.get<std::uint32_t>();
      part.bodies = in.get<std::uint32_t>();
      parts_.emplace_back(Node(rank, island), part);
    }
    while (in.remaining() > 0 && !in.failed()) {
      const auto island = in.get<std::uint32_t>();
      const auto other = in.get<int>();
      const auto other_island = in.get<std::uint32_t>();
      all_links_.emplace_back(Node(rank, island), Node(other, other_island));
    }
    ++rank;
  }
}

std::uint32_t IslandAgreement::index_of(const Node& node) const {
  const auto at =
      std::lower_bound(parts_.begin(), parts_.end(), node,
                       [](const auto& part, const Node& wanted) { return part.first < wanted; });
  if (at == parts_.end() || at->first != node) Environment::abort("ranks disagree on islands");
  return static_cast<std::uint32_t>(at - parts_.begin());
}

std::uint32_t IslandAgreement::root_of(std::uint32_t node) {
  while (parents_[node] != node) {
    parents_[node] = parents_[parents_[node]];
    node = parents_[node];
  }
  return node;
}

void IslandAgreement::join(const Node& l, const Node& r) {
  const std::uint32_t a = root_of(index_of(l));
  const std::uint32_t b = root_of(index_of(r));
  parents_[std::max(a, b)] = std::min(a, b);
}

void IslandAgreement::agree_awake(std::span<const std::uint32_t> island_of,
                                  std::span<pbd::IslandPart> islands) {
  island_of_.assign(island_of.begin(), island_of.end());
  exchange_links(island_of);
  gather_parts(islands);
  parents_.resize(parts_.size());
  for (std::uint32_t i = 0; i < parents_.size(); ++i) parents_[i] = i;
  for (const auto& [l, r] : all_links_) join(l, r);
  cut_.clear();
  own_cut_.clear();
  std::vector<std::uint32_t> number(parts_.size(), kNone);  // by root
  for (std::uint32_t i = 0; i < parts_.size(); ++i) {
    const std::uint32_t root = root_of(i);
    if (number[root] == kNone) {
      number[root] = static_cast<std::uint32_t>(cut_.size());
      cut_.emplace_back();
    }
    CutIsland& whole = cut_[number[root]];
    const CutIsland& part = parts_[i].second;
    whole.awake = whole.awake || part.awake;
    whole.level_sum += part.level_sum;
    whole.bodies += part.bodies;
    if (parts_[i].first.first == ranks_.rank()) {
      own_cut_.emplace_back(parts_[i].first.second, number[root]);
    }
  }
  for (const auto& [island, cut] : own_cut_) {
    islands[island].awake = cut_[cut].awake;
    islands[island].level_sum = cut_[cut].level_sum;
    islands[island].bodies = cut_[cut].bodies;
  }
}

void IslandAgreement::agree_rest(std::span<const std::uint32_t> /*island_of*/,
                                 std::span<pbd::IslandPart> islands) {
  bytes_.clear();
  MessageWriter out(bytes_);
  out.put(load_);
  out.put<std::uint8_t>(neighbours_.outdated() ? 1 : 0);
  for (const auto& [island, cut] : own_cut_) {
    const pbd::IslandPart& part = islands[island];
    out.put(cut);
    out.put<std::uint8_t>(static_cast<std::uint8_t>((part.held ? 1 : 0) | (part.driven ? 2 : 0) |
                                                    (part.sleepy ? 4 : 0)));
    out.put(part.wanted);
  }
  news_.clear();
  for (MessageReader& in : ranks_.gather(bytes_)) {
    RankNews& news = news_.emplace_back();
    news.load = in.get<double>();
    news.outdated = in.get<std::uint8_t>() != 0;
    while (in.remaining() > 0) {
      const auto cut = in.get<std::uint32_t>();
      const auto flags = in.get<std::uint8_t>();
      const auto wanted = in.get<double>();
      if (in.failed() || cut >= cut_.size()) Environment::abort("ranks disagree on islands");
      CutIsland& whole = cut_[cut];
      whole.held = whole.held || (flags & 1) != 0;
      whole.driven = whole.driven || (flags & 2) != 0;
      whole.sleepy = whole.sleepy && (flags & 4) != 0;
      whole.wanted = std::max(whole.wanted, wanted);
    }
  }
  for (const auto& [island, cut] : own_cut_) {
    islands[island].held = cut_[cut].held;
    islands[island].driven = cut_[cut].driven;
    islands[island].sleepy = cut_[cut].sleepy;
    islands[island].wanted = cut_[cut].wanted;
  }
}

}  // namespace tandem::mpi
