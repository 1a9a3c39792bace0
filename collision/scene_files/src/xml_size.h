// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>

#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {

/// Bounds for parsers that call themselves for each element within another, and hold all of them.
inline void check_xml_size(std::string_view text, std::string_view name) {
  constexpr std::size_t kMaxElements = 200'000;
  std::size_t open = 0;
  std::size_t elements = 0;
  const auto check = [name](const char* what, std::size_t value, std::size_t most) {
    if (value <= most) return;
    throw SceneFileError(pbd::detail::must_be(
        std::string(name) + ": " + what, "at most " + std::to_string(most), std::to_string(value)));
  };
  check("size", text.size(), kMaxSceneBytes);
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    const bool opens =
        text[i] == '<' && text[i + 1] != '/' && text[i + 1] != '!' && text[i + 1] != '?';
    const bool closes =
        (text[i] == '<' && text[i + 1] == '/') || (text[i] == '/' && text[i + 1] == '>');
    if (opens) check("number of elements", ++elements, kMaxElements);
    if (opens) check("depth", ++open, 200);
    if (closes && open > 0) --open;
  }
}

}  // namespace tandem::scene_files
