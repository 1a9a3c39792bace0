// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// Tracks which slots of arrays are in use. An element keeps its slot while it lives; a reused slot
/// has a new generation, so that stale ids name nothing. The owner keeps the arrays, size() long.
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
  /// Takes the slot that was freed last, or appends a new one if none is free.
  std::uint32_t take() {
    if (free_.empty()) {
      alive_.push_back(1);
      generations_.push_back(0);
      free_.reserve(alive_.capacity());  // release() must not allocate
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
  /// Becomes a copy whose release() does not allocate either.
  void assign(const Slots& source) {
    alive_ = source.alive_;
    generations_ = source.generations_;
    free_ = source.free_;
    free_.reserve(alive_.size());
  }

  // For snapshots: each slot, then the free list.
  void save_slot(ByteWriter& out, std::uint32_t slot) const {
    out.u8(alive_[slot]);
    out.u32(generations_[slot]);
  }
  void load_slot(ByteReader& in) {
    alive_.push_back(in.u8() != 0 ? 1 : 0);
    generations_.push_back(in.u32());
  }
  void save_free(ByteWriter& out) const;
  /// Fails `in` unless it names each unused slot exactly once.
  void load_free(ByteReader& in);

 private:
  std::vector<std::uint8_t> alive_;
  std::vector<std::uint32_t> generations_;
  std::vector<std::uint32_t> free_;
};

}  // namespace tandem::pbd
