// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "limit_count.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {

using nlohmann::json;

/// What one reading has in common.
struct Reading {
  std::string_view file;
  std::vector<std::string> warnings{};
  LimitCount limits{};
  bool strict = false;  ///< faults of shapes are errors
};

/// A value of a document and where it is. It lives no longer than the place that it is in.
class Place {
 public:
  Place(const json& value, Reading& reading) : value_(&value), reading_(&reading) {}

  const json& value() const { return *value_; }
  std::string pointer() const;

  bool has(const char* key) const { return value_->is_object() && value_->contains(key); }
  Place at(const char* key) const;       ///< refuses what is no object or has it not
  Place at(std::size_t index) const;     ///< likewise
  std::size_t size() const;              ///< of an array; refuses others
  Place pick(const Place& index) const;  ///< of an array, the one that `index` names

  double number() const;  ///< finite, or "Infinity" or "-Infinity"
  std::string text() const;
  /// An integer from low to high.
  std::int64_t integer(std::int64_t low, std::int64_t high) const;

  [[noreturn]] void refuse(std::string_view rule) const;
  void warn(std::string_view what) const;
  /// Whether a fault that could be mended is an error.
  bool strict() const { return reading_->strict; }
  /// One more of what is bounded, or several: refuses where that is too many.
  void count(std::size_t SceneLimits::*what, std::size_t count = 1) const;
  /// Its own values are the colliders of one body.
  void count_parts() const;
  /// Runs `call`; what it refuses gets the place in front.
  void guard(const std::function<void()>& call) const;

 private:
  const json* value_;
  Reading* reading_;
  const Place* parent_ = nullptr;
  std::string_view key_;
  std::size_t index_ = 0;
};

/// The start of a value as messages show it.
std::string excerpt(const json& value);
/// A document, within the bounds of kMaxSceneBytes and kMaxSceneDepth.
json parse_document(std::string_view text, std::string_view file);

}  // namespace tandem::scene_files
