// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tandem::scene_files {

/// Two digits: enough for an error.
inline std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

/// Warnings of a file with many elements: a warning common to several of a kind is given once, with
/// all their names.
class GroupedWarnings {
 public:
  /// @param kind, name  of the element. @param text  the warning
  void add(const std::string& kind, const std::string& name, const std::string& text) {
    const auto [at, is_new] = places_.try_emplace({kind, text}, lines_.size());
    if (is_new) lines_.push_back({kind + ' ', text});
    auto& names = lines_[at->second].first;
    if (!is_new) names += ", ";
    names += name;
  }
  /// In the order of the first occurrence.
  void append_to(std::vector<std::string>& out) const {
    for (const auto& [names, text] : lines_) {
      out.push_back(names);
      out.back() += ": ";
      out.back() += text;
    }
  }

 private:
  std::map<std::pair<std::string, std::string>, std::size_t> places_;  ///< index in lines_
  std::vector<std::pair<std::string, std::string>> lines_;
};

}  // namespace tandem::scene_files
