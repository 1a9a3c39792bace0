// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::mjcf {

/// A text that MuJoCo reads, the model first, then what it includes.
struct Document {
  std::string file;  ///< without folders
  std::string text;
  bool changed = false;
};

/// What MuJoCo's schema does not know, by its own message.
struct SchemaViolation {
  std::string element;
  std::string attribute;  ///< empty: the element itself is not known
  std::size_t line = 0;   ///< of the model; 0: of an included file, or not told
};
std::optional<SchemaViolation> schema_violation(std::string_view message);

/// Puts spaces in its place, wherever it is: lines keep their numbers.
/// @return how often it was there
std::size_t blank_out(const SchemaViolation& what, std::vector<Document>& documents);

/// Has a range mean a limit in the model, as later ones of MuJoCo have it by default.
/// @return whether there was a place for it
bool set_autolimits(Document& model);

/// What `documents` includes, and what that does, appended. What cannot be read is left to MuJoCo.
void append_includes(const std::filesystem::path& folder, std::vector<Document>& documents);

}  // namespace tandem::mjcf
