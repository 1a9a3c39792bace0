// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::mjcf {

/// A text that MuJoCo reads: the model first, then its includes.
struct Document {
  std::string file;  ///< without folders
  std::string text;
  bool changed = false;
};

/// An element, an attribute or a keyword of <option> that MuJoCo does not know, or a light that it
/// does not accept, by MuJoCo's message.
struct SchemaViolation {
  std::string element;
  std::string attribute = {};  ///< empty: the element itself is unknown
  std::string value = {};      ///< keyword of any attribute
  std::size_t line = 0;        ///< line in the model; 0: in an included file, or unknown

  /// What is left out, in words.
  std::string title() const {
    if (!value.empty()) return '"' + value + '"';
    return attribute.empty() ? "the element" : attribute;
  }
};
std::optional<SchemaViolation> schema_violation(std::string_view message);

/// Overwrites all its occurrences with spaces: line numbers stay.
/// @return the number of occurrences
std::size_t blank_out(const SchemaViolation& what, std::vector<Document>& documents);

/// Makes a range imply a limit in the model, the default of later MuJoCo versions.
/// @return whether there was a place for it
bool set_autolimits(Document& model);

/// Appends the files that `documents` include, recursively. Unreadable ones are left to MuJoCo.
void append_includes(const std::filesystem::path& folder, std::vector<Document>& documents);

}  // namespace tandem::mjcf
