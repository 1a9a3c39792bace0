// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <string_view>

namespace tandem::demos::view {

struct Asset {
  std::string_view path;  ///< "" is the page itself
  std::string_view mime;
  std::string_view bytes;
};

/// The page and all its files, built in.
std::span<const Asset> page_assets();

}  // namespace tandem::demos::view
