// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// Which slots of arrays are in use. What comes and goes keeps its slot while it is there; a slot
/// that is used again has another generation, so that an id of what is gone names nothing.
/// The arrays themselves are the owner's, as long as size().
class TANDEM_API Slots {
 public:
  std::uint32_t size() const { return static_cast<std::uint32_t>(alive_.size()); }
  std::size_t count() const { return alive_.size() - free_.size(); }  ///< in use
  bool alive(std::uint32_t slot) const { return alive_[slot] != 0; }
  std::uint32_t generation(std::uint32_t slot) const { return generations_[slot]; }
  bool contains(std::uint32_t slot, std::uint32_t generation) const {
    return slot < alive_.size() && alive_[slot] != 0 && generations_[slot] == generation;
  }

  void reserve(std::size_t slots) {
    alive_.reserve(slots);
    generations_.reserve(slots);
  }
  /// The slot that was freed last; where none is free a new one at the end.
  std::uint32_t take() {
    if (free_.empty()) {
      alive_.push_back(1);
      generations_.push_back(0);
      free_.reserve(alive_.capacity());  // so that release() needs no memory
      return size() - 1;
    }
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    alive_[slot] = 1;
    return slot;
  }
  /// @pre the slot is in use
  void release(std::uint32_t slot) {
    alive_[slot] = 0;
    ++generations_[slot];
    free_.push_back(slot);
  }
  void clear() {
    alive_.clear();
    generations_.clear();
    free_.clear();
  }
  /// Become a copy, whose release() needs no memory either.
  void assign(const Slots& source) {
    alive_ = source.alive_;
    generations_ = source.generations_;
    free_ = source.free_;
    free_.reserve(alive_.size());
  }

  // For snapshots: the slots one by one, then those that are free.
  void save_slot(ByteWriter& out, std::uint32_t slot) const {
    out.u8(alive_[slot]);
    out.u32(generations_[slot]);
  }
  void load_slot(ByteReader& in) {
    alive_.push_back(in.u8() != 0 ? 1 : 0);
    generations_.push_back(in.u32());
  }
  void save_free(ByteWriter& out) const;
  /// Fails `in` where it does not name each slot that is not in use, once.
  void load_free(ByteReader& in);

 private:
  std::vector<std::uint8_t> alive_;
  std::vector<std::uint32_t> generations_;
  std::vector<std::uint32_t> free_;
};

}  // namespace tandem::pbd
