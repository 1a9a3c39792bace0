// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <charconv>
#include <concepts>
#include <string_view>
#include <system_error>

#include "tandem/pbd/export.h"

namespace tandem::pbd::detail {

/// Whether the whole of `text` is a number that fits: as std::from_chars reads it, whatever the
/// locale. Standard libraries that read no floating-point numbers so (libc++ before 20) do as well.
TANDEM_API bool parse_number(std::string_view text, double& value);

template <std::integral Integer>
bool parse_number(std::string_view text, Integer& value) {
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} && at == end;
}

}  // namespace tandem::pbd::detail
