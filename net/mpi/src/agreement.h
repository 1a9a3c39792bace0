// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "neighbours.h"
#include "tandem/pbd/island_coupling.h"

namespace tandem::mpi {

/// What each rank sends to all others at the end of a step.
struct RankNews {
  double load = 0.0;      ///< counted work, see Load
  bool outdated = false;  ///< Neighbours::outdated()
};

/// An island that lies on several ranks, the same on all of them.
struct CutIsland {
  bool awake = false;
  bool held = false;
  bool driven = false;
  bool sleepy = true;
  std::uint32_t level_sum = 0;
  std::uint32_t bodies = 0;
  double wanted = 0.0;
};

/// Islands that continue on other ranks: found by the ranks that solve the contacts in between, and
/// joined by all ranks from a short list of links.
class IslandAgreement final : public pbd::IslandCoupling {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  IslandAgreement(Part& part, Ranks& ranks, Neighbours& neighbours)
      : part_(part), ranks_(ranks), neighbours_(neighbours) {}

  std::span<const std::uint8_t> copies() const override { return part_.copies(); }
  void agree_awake(std::span<const std::uint32_t> island_of,
                   std::span<pbd::IslandPart> islands) override;
  void agree_rest(std::span<const std::uint32_t> island_of,
                  std::span<pbd::IslandPart> islands) override;

  /// Sent with the next agree_rest(), and received, by rank.
  void set_news(double load) { load_ = load; }
  std::span<const RankNews> news() const { return news_; }

  /// Of the last step: by slot, the island's lowest slot.
  std::span<const std::uint32_t> islands() const { return island_of_; }
  /// The cut island that contains an island (by its lowest slot), or kNone.
  std::uint32_t cut_island(std::uint32_t island) const;
  std::span<const CutIsland> cut() const { return cut_; }
  std::size_t own_cut_count() const { return own_cut_.size(); }

 private:
  /// An island of a rank.
  using Node = std::pair<int, std::uint32_t>;
  void exchange_links(std::span<const std::uint32_t> island_of);
  void gather_parts(std::span<const pbd::IslandPart> islands);
  std::uint32_t root_of(std::uint32_t node);
  void join(const Node& l, const Node& r);
  std::uint32_t index_of(const Node& node) const;

  Part& part_;
  Ranks& ranks_;
  Neighbours& neighbours_;
  double load_ = 0.0;
  std::vector<RankNews> news_;
  std::vector<std::uint32_t> island_of_;
  std::vector<std::pair<std::uint32_t, Node>> links_;  ///< an own island, and the other one
  std::vector<std::uint32_t> own_parts_;               ///< own islands in links_, ascending
  std::vector<std::pair<Node, CutIsland>> parts_;      ///< all ranks', by node
  std::vector<std::pair<Node, Node>> all_links_;
  std::vector<std::uint32_t> parents_;                            ///< of parts_
  std::vector<std::pair<std::uint32_t, std::uint32_t>> own_cut_;  ///< own island, cut island
  std::vector<CutIsland> cut_;
  Bytes bytes_;
};

}  // namespace tandem::mpi
