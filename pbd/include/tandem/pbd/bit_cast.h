// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstring>
#include <type_traits>

namespace tandem::pbd {

/// The bits of a value as another type. Replaces std::bit_cast, which emscripten 3.1's C++ library
/// lacks.
template <class To, class From>
To bit_cast(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  static_assert(std::is_trivially_copyable_v<To> && std::is_trivially_copyable_v<From>);
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}

}  // namespace tandem::pbd
