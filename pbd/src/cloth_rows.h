// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/cloth_block.h"

namespace tandem::pbd {

/// Whether no body is listed twice.
bool all_differ(std::vector<BodyId> bodies);

/// Definitions of the rows of a ClothBlock. Each scalar of a row has an index in the arrays of
/// carried and scratch numbers, from `at` on: one per length of a strand, one for a tether, three
/// for means and attachments.
struct ClothRows {
  struct Strand {
    std::uint64_t id = 0;
    std::uint32_t first = 0;  ///< index into points and lengths
    std::uint32_t count = 0;  ///< number of points
    double compliance = 0.0;  ///< 1/N
    std::uint32_t at = 0;
  };
  struct Tether {
    std::uint64_t id = 0;
    BodyId a = {}, b = {};
    double length = 0.0;  ///< m
    std::uint32_t at = 0;
  };
  struct Mean {
    std::uint64_t id = 0;
    std::uint32_t first = 0;  ///< index into mean_points and weights
    std::uint32_t count = 0;  ///< number of points
    double compliance = 0.0;  ///< m/N
    bool leads = false;
    std::uint32_t at = 0;
  };
  struct Attachment {
    std::uint64_t id = 0;
    BodyId particle = {}, host = {};
    Vec3 anchor_l = Vec3::Zero();  ///< m, frame of the host
    std::uint32_t at = 0;
  };

  std::vector<Strand> strands;
  std::vector<BodyId> points;   ///< points of strands
  std::vector<double> lengths;  ///< m, of strands; 0 for the last point of each
  std::vector<Tether> tethers;
  std::vector<Mean> means;
  std::vector<BodyId> mean_points;
  std::vector<double> weights;
  std::vector<Attachment> attachments;
  std::uint64_t next_id = 1;

  bool empty() const {
    return strands.empty() && tethers.empty() && means.empty() && attachments.empty();
  }
  std::size_t row_count() const {
    return points.size() - strands.size() + tethers.size() + means.size() + attachments.size();
  }
  /// Numbers the scalars, row by row. @return their number
  std::size_t number();
  /// Visits the scalars of each row, in the order of number().
  template <class Visit>
  void for_scalars(Visit&& visit) const;
  /// Removes the rows that `gone_id` or `gone_body` names: a strand is split where a point is
  /// removed.
  /// @param carried  by scalar, as numbered; updated
  template <class GoneId, class GoneBody>
  void erase(std::vector<double>& carried, const GoneId& gone_id, const GoneBody& gone_body);
  /// Visits pairs of bodies that a row names one after the other.
  template <class Visit>
  void for_neighbours(Visit&& visit) const;

  /// Whether a row names the body, other than as the host of an attachment.
  bool is_point(BodyId body) const;

  void save(ByteWriter& out) const;
  /// Fails `in` on bytes that are not from save().
  void load(ByteReader& in);
  bool fits(const World& world) const;
};

template <class Visit>
void ClothRows::for_neighbours(Visit&& visit) const {
  for (const Strand& strand : strands) {
    for (std::uint32_t i = 1; i < strand.count; ++i) {
      visit(points[strand.first + i - 1], points[strand.first + i]);
    }
  }
  for (const Tether& tether : tethers) visit(tether.a, tether.b);
  for (const Mean& mean : means) {
    for (std::uint32_t i = mean.first + 1; i < mean.first + mean.count; ++i) {
      visit(mean_points[i - 1], mean_points[i]);
    }
  }
  for (const Attachment& attachment : attachments) visit(attachment.particle, attachment.host);
}

template <class Visit>
void ClothRows::for_scalars(Visit&& visit) const {
  for (const Strand& strand : strands) visit(strand.at, strand.count - 1);
  for (const Tether& tether : tethers) visit(tether.at, 1u);
  for (const Mean& mean : means) visit(mean.at, 3u);
  for (const Attachment& attachment : attachments) visit(attachment.at, 3u);
}

template <class GoneId, class GoneBody>
void ClothRows::erase(std::vector<double>& carried, const GoneId& gone_id,
                      const GoneBody& gone_body) {
  ClothRows kept;
  std::vector<double> kept_carried;
  kept.next_id = next_id;
  const auto keep = [&](std::uint32_t at, std::size_t scalars) {
    for (std::size_t k = 0; k < scalars; ++k) kept_carried.push_back(carried[at + k]);
  };
  for (const Strand& strand : strands) {
    if (gone_id(strand.id)) continue;
    for (std::uint32_t from = 0, i = 0; i <= strand.count; ++i) {
      if (i < strand.count && !gone_body(points[strand.first + i])) continue;
      if (i >= from + 2) {
        const auto first = static_cast<std::uint32_t>(kept.points.size());
        kept.strands.push_back({strand.id, first, i - from, strand.compliance, 0});
        for (std::uint32_t k = from; k < i; ++k) {
          kept.points.push_back(points[strand.first + k]);
          kept.lengths.push_back(k + 1 < i ? lengths[strand.first + k] : 0.0);
        }
        keep(strand.at + from, i - from - 1);
      }
      from = i + 1;
    }
  }
  for (const Tether& tether : tethers) {
    if (gone_id(tether.id) || gone_body(tether.a) || gone_body(tether.b)) continue;
    kept.tethers.push_back(tether);
    keep(tether.at, 1);
  }
  for (const Mean& mean : means) {
    bool gone = gone_id(mean.id);
    const auto from = mean_points.begin() + mean.first, to = from + mean.count;
    gone = gone || std::any_of(from, to, gone_body);
    if (gone) continue;
    kept.means.push_back(mean);
    kept.means.back().first = static_cast<std::uint32_t>(kept.mean_points.size());
    kept.mean_points.insert(kept.mean_points.end(), from, to);
    const auto weight = weights.begin() + mean.first;
    kept.weights.insert(kept.weights.end(), weight, weight + mean.count);
    keep(mean.at, 3);
  }
  for (const Attachment& attachment : attachments) {
    if (gone_id(attachment.id) || gone_body(attachment.particle) || gone_body(attachment.host)) {
      continue;
    }
    kept.attachments.push_back(attachment);
    keep(attachment.at, 3);
  }
  kept.number();
  *this = std::move(kept);
  carried = std::move(kept_carried);
}

}  // namespace tandem::pbd
