// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// Index of rows by the one or two bodies that they name. Rows and bodies are the owner's numbers;
/// BodyId::kNone is no body.
class TANDEM_API ByBody {
 public:
  /// @pre the row is not in the index
  void add(std::uint32_t row, std::uint32_t body_a, std::uint32_t body_b = BodyId::kNone) {
    if (old_) return;
    link(2 * row, body_a);
    link(2 * row + 1, body_b);
  }
  /// No effect if the row is not in the index.
  void remove(std::uint32_t row) {
    if (old_) return;
    unlink(2 * row);
    unlink(2 * row + 1);
  }
  /// Marks the whole index as outdated: renew() rebuilds it.
  void outdate() { old_ = true; }
  /// Rebuilds an outdated index: `add_all()` adds the rows.
  void renew(auto&& add_all) {
    if (!old_) return;
    old_ = false;
    first_.clear();
    for (std::vector<End>& ends : ends_) ends.clear();
    add_all();
  }
  /// Calls visit(row, other) for each row that names the body, in unspecified order; `other` is the
  /// row's other body. The visitor may remove the row.
  void for_rows(std::uint32_t body, auto&& visit) const {
    std::uint32_t next = body < first_.size() ? first_[body] : kNone;
    while (next != kNone) {
      const std::uint32_t at = next;
      next = end(at).after;
      visit(at / 2, known(at ^ 1u) ? end(at ^ 1u).body : BodyId::kNone);
    }
  }
  /// The rows of the body, ascending, whatever the order in which they were added.
  std::vector<std::uint32_t> rows_of(std::uint32_t body) const {
    std::vector<std::uint32_t> rows;
    for_rows(body, [&](std::uint32_t row, std::uint32_t) { rows.push_back(row); });
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    return rows;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  /// One end of a row, linked with the other ends that name the same body.
  struct End {
    std::uint32_t body = BodyId::kNone;
    std::uint32_t before = kNone, after = kNone;  ///< 2 * row, plus 1 for its second end
  };

  bool known(std::uint32_t at) const { return at / 2 < ends_[at % 2].size(); }
  End& end(std::uint32_t at) { return ends_[at % 2][at / 2]; }
  const End& end(std::uint32_t at) const { return ends_[at % 2][at / 2]; }

  void link(std::uint32_t at, std::uint32_t body) {
    if (body == BodyId::kNone) return;
    // A copy: a DLL would export a constant to which it has a reference.
    if (body >= first_.size()) first_.resize(body + std::size_t{1}, std::uint32_t{kNone});
    if (!known(at)) ends_[at % 2].resize(at / 2 + std::size_t{1});
    end(at) = {body, kNone, first_[body]};
    if (first_[body] != kNone) end(first_[body]).before = at;
    first_[body] = at;
  }
  void unlink(std::uint32_t at) {
    if (!known(at)) return;
    const End old = end(at);
    if (old.body == BodyId::kNone) return;
    (old.before == kNone ? first_[old.body] : end(old.before).after) = old.after;
    if (old.after != kNone) end(old.after).before = old.before;
    end(at) = {};
  }

  std::vector<std::uint32_t> first_;  ///< by body: head of its list of ends
  /// By row: first ends; second ends, up to the last row that has two.
  std::array<std::vector<End>, 2> ends_;
  bool old_ = false;
};

}  // namespace tandem::pbd
