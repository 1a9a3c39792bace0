// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::obj {

/// One `f` line.
struct Face {
  std::size_t line = 0;
  std::vector<std::uint32_t> corners;  ///< indices into the vertices
};

struct ObjText {
  std::vector<pbd::Vec3> vertices;
  std::vector<Face> faces;
};

/// @throws std::invalid_argument  see load_obj.h
ObjText parse(const std::string& text, std::string_view name);

/// Throws std::invalid_argument: "name:line: what must be rule, is value"; without line if it is 0.
[[noreturn]] void refuse(std::string_view name, std::size_t line, std::string_view what,
                         std::string_view rule, std::string_view value = {});

}  // namespace tandem::obj
