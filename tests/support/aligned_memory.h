// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdlib>

#ifdef _WIN32
#include <malloc.h>
#endif

namespace tandem::testing {

/// Basis of operator new for aligned types; null without memory.
/// @param alignment  a power of two
inline void* aligned_memory(std::size_t size, std::size_t alignment) {
#ifdef _WIN32
  return _aligned_malloc(size, alignment);
#else
  return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
#endif
}

inline void free_aligned(void* memory) {
#ifdef _WIN32
  _aligned_free(memory);
#else
  std::free(memory);
#endif
}

}  // namespace tandem::testing
