// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "members/index_tables.h"

#include <algorithm>

namespace tandem::consensus {
namespace {

/// ns: names come reliably and may be late by some resends.
constexpr SessionTime kIndexPatience = 500'000'000;

template <class Tables>
auto* table_of(Tables& tables, PeerId from) {
  const auto it = std::ranges::find_if(tables, [from](const auto& t) { return t.peer == from; });
  return it != tables.end() ? &*it : nullptr;
}

}  // namespace

void IndexTables::learn(PeerId from, const IndexAssignment& name, std::size_t most) {
  Table* table = table_of(tables_, from);
  if (table == nullptr) {
    tables_.push_back({.peer = from, .number = name.table, .names = {}});
    table = &tables_.back();
  } else if (table->number != name.table) {
    table->number = name.table;
    table->names.clear();
  }
  const auto at = std::ranges::lower_bound(table->names, name.index, {}, &Name::index);
  if (at != table->names.end() && at->index == name.index) {
    at->id = name.id;
  } else if (table->names.size() < most) {
    table->names.insert(at, {name.index, name.id});
  }
}

const SharedId* IndexTables::find(PeerId from, const CompactState& state) const {
  const Table* const table = table_of(tables_, from);
  if (table == nullptr || table->number != state.table) return nullptr;
  // Where all have been told, a name is at the place of its index.
  const auto& names = table->names;
  if (state.index < names.size() && names[state.index].index == state.index) {
    return &names[state.index].id;
  }
  const auto at = std::ranges::lower_bound(names, state.index, {}, &Name::index);
  return at != names.end() && at->index == state.index ? &at->id : nullptr;
}

void IndexTables::forget(PeerId from) {
  std::erase_if(tables_, [from](const Table& table) { return table.peer == from; });
}

bool IndexTables::should_ask(PeerId from, bool missed, SessionTime now) {
  Table* table = table_of(tables_, from);
  if (table == nullptr) {
    if (!missed) return false;
    tables_.push_back({.peer = from, .names = {}});
    table = &tables_.back();
  }
  if (!missed) {
    table->missing_since = 0;
    return false;
  }
  if (table->missing_since == 0) table->missing_since = now;
  if (now - table->missing_since < kIndexPatience) return false;
  table->missing_since = now;
  return true;
}

}  // namespace tandem::consensus
