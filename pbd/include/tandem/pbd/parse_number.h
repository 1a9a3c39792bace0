// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <charconv>
#include <concepts>
#include <string_view>
#include <system_error>

#include "tandem/pbd/export.h"

namespace tandem::pbd::detail {

/// Whether the whole of `text` is a number in range, read as by std::from_chars in any locale.
/// Works with standard libraries whose std::from_chars lacks floating point (libc++ before 20).
TANDEM_API bool parse_number(std::string_view text, double& value);

template <std::integral Integer>
bool parse_number(std::string_view text, Integer& value) {
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} && at == end;
}

}  // namespace tandem::pbd::detail
