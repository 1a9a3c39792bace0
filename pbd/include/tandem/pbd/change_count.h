// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// A number that changes with each change of the object that holds it, assignment included.
class TANDEM_API ChangeCount {
 public:
  ChangeCount() = default;
  ChangeCount(const ChangeCount&) noexcept = default;
  ChangeCount& operator=(const ChangeCount& other) noexcept {
    value_ = std::max(value_, other.value_) + 1;
    return *this;
  }
  void note() { ++value_; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

}  // namespace tandem::pbd
