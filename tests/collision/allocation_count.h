// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>

namespace tandem::collision::testing {

/// Calls of operator new in this program so far; counted in allocation_count.cpp.
std::size_t allocations_so_far();

/// Calls of operator new since it was made.
class AllocationCount {
 public:
  AllocationCount() : start_(allocations_so_far()) {}
  std::size_t count() const { return allocations_so_far() - start_; }

 private:
  std::size_t start_;
};

}  // namespace tandem::collision::testing
