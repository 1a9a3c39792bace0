// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "members/index_tables.h"

#include <algorithm>
#include <utility>

#include "common/ranges.h"

namespace tandem::consensus {
namespace {

/// ns: index messages are reliable and may be late by some resends.
/// tests/consensus/sending_test.cpp fails at a third of it and at three times as much.
constexpr SessionTime kIndexPatience = 500'000'000;

}  // namespace

IndexTables::Table& IndexTables::table_of(PeerId from) {
  const auto at = ranges::find(tables_, from, &Table::peer);
  return at != tables_.end() ? *at : tables_.emplace_back(Table{.peer = from, .names = {}});
}

void IndexTables::learn(PeerId from, const IndexAssignment& name, std::size_t most) {
  Table& table = table_of(from);
  if (std::exchange(table.number, name.table) != name.table) table.names.clear();
  const auto at = ranges::lower_bound(table.names, name.index, &Name::index);
  if (at != table.names.end() && at->index == name.index) {
    at->id = name.id;
  } else if (table.names.size() < most) {
    table.names.insert(at, {name.index, name.id});
  }
}

const SharedId* IndexTables::find(PeerId from, const CompactState& state) const {
  const auto table = ranges::find(tables_, from, &Table::peer);
  if (table == tables_.end() || table->number != state.table) return nullptr;
  // If no index is missing, a name is at the place of its index.
  const auto& names = table->names;
  if (state.index < names.size() && names[state.index].index == state.index) {
    return &names[state.index].id;
  }
  const auto at = ranges::lower_bound(names, state.index, &Name::index);
  return at != names.end() && at->index == state.index ? &at->id : nullptr;
}

void IndexTables::forget(PeerId from) {
  std::erase_if(tables_, [from](const Table& table) { return table.peer == from; });
}

bool IndexTables::should_ask(PeerId from, bool missed, SessionTime now) {
  SessionTime& since = table_of(from).missing_since;
  if (!missed) since = 0;
  if (missed && since == 0) since = now;
  if (!missed || now - since < kIndexPatience) return false;
  since = now;
  return true;
}

}  // namespace tandem::consensus
