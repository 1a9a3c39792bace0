// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// Rows by the bodies that they name, one or two of them: those of one body are found without a
/// look at the others. Rows and bodies are numbers of the owner's; BodyId::kNone is no body.
class TANDEM_API ByBody {
 public:
  /// @pre the row is not in
  void add(std::uint32_t row, std::uint32_t body_a, std::uint32_t body_b = BodyId::kNone) {
    if (old_) return;
    if (ends_.size() < 2 * (row + std::size_t{1})) ends_.resize(2 * (row + std::size_t{1}));
    link(2 * row, body_a);
    link(2 * row + 1, body_b);
  }
  /// Of no effect where the row is not in.
  void remove(std::uint32_t row) {
    if (old_ || 2 * std::size_t{row} >= ends_.size()) return;
    unlink(2 * row);
    unlink(2 * row + 1);
  }
  /// What the rows are has changed as a whole: renew() is to look at them.
  void outdate() { old_ = true; }
  /// Where it is outdated, begin anew: `add_all()` adds the rows.
  void renew(auto&& add_all) {
    if (!old_) return;
    old_ = false;
    first_.clear();
    ends_.clear();
    add_all();
  }
  /// Call visit(row, other) for each row that names the body, in no order that means anything;
  /// `other` is what it names besides. The visitor may remove the row.
  void for_rows(std::uint32_t body, auto&& visit) const {
    std::uint32_t next = body < first_.size() ? first_[body] : kNone;
    while (next != kNone) {
      const std::uint32_t at = next;
      next = ends_[at].after;
      visit(at / 2, ends_[at ^ 1u].body);
    }
  }
  /// Those rows, ascending: what is done to them then does not depend on how they came in.
  std::vector<std::uint32_t> rows_of(std::uint32_t body) const {
    std::vector<std::uint32_t> rows;
    for_rows(body, [&](std::uint32_t row, std::uint32_t) { rows.push_back(row); });
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    return rows;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  /// What one row names at one end, among all that name the same body.
  struct End {
    std::uint32_t body = BodyId::kNone;
    std::uint32_t before = kNone, after = kNone;  ///< into ends_
  };

  void link(std::uint32_t at, std::uint32_t body) {
    if (body == BodyId::kNone) return;
    if (body >= first_.size()) first_.resize(body + std::size_t{1}, kNone);
    ends_[at] = {body, kNone, first_[body]};
    if (first_[body] != kNone) ends_[first_[body]].before = at;
    first_[body] = at;
  }
  void unlink(std::uint32_t at) {
    const End end = ends_[at];
    if (end.body == BodyId::kNone) return;
    (end.before == kNone ? first_[end.body] : ends_[end.before].after) = end.after;
    if (end.after != kNone) ends_[end.after].before = end.before;
    ends_[at] = {};
  }

  std::vector<std::uint32_t> first_;  ///< by body, into ends_
  std::vector<End> ends_;             ///< two of each row
  bool old_ = false;
};

}  // namespace tandem::pbd
