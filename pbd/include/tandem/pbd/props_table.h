// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// Properties of bodies by slot. Plain static bodies, such as the parts of a level, share one
/// record.
class TANDEM_API PropsTable {
 public:
  /// Iterates over all slots.
  class Iterator {
   public:
    Iterator(const PropsTable& table, std::size_t slot) : table_(&table), slot_(slot) {}
    const BodyProps& operator*() const { return (*table_)[slot_]; }
    Iterator& operator++() {
      ++slot_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return slot_ == other.slot_; }

   private:
    const PropsTable* table_;
    std::size_t slot_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }
  std::size_t size() const { return record_of_.size(); }
  const BodyProps& operator[](std::size_t slot) const { return records_[record_of_[slot]]; }

  /// New slots have default BodyProps.
  void resize(std::size_t slots);
  void reserve(std::size_t slots) { record_of_.reserve(slots); }
  void set(std::size_t slot, const BodyProps& props);
  /// For changes of one field. Gives the body a record of its own, which may move other records.
  BodyProps& own(std::size_t slot);
  /// Become a copy; memory is reused.
  void assign(const PropsTable& source);

 private:
  void release(std::size_t slot);

  std::vector<BodyProps> records_;        ///< the first one is shared
  std::vector<std::uint32_t> record_of_;  ///< by slot
  std::vector<std::uint32_t> free_;       ///< unused records
};

}  // namespace tandem::pbd
