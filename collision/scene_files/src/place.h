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

/// Shared state of one reading.
struct Reading {
  std::string_view file;
  std::vector<std::string> warnings{};
  LimitCount limits{};
  bool strict = false;  ///< invalid shapes are errors
};

/// A value of a document and its place. Must not outlive the place that contains it.
class Place {
 public:
  Place(const json& value, Reading& reading) : value_(&value), reading_(&reading) {}

  const json& value() const { return *value_; }
  std::string pointer() const;

  bool has(const char* key) const { return value_->is_object() && value_->contains(key); }
  Place at(const char* key) const;       ///< refuses a non-object and a missing key
  Place at(std::size_t index) const;     ///< refuses a non-array and an index out of range
  std::size_t size() const;              ///< of an array; refuses others
  Place pick(const Place& index) const;  ///< element of an array that `index` names

  double number() const;  ///< finite, or "Infinity" or "-Infinity"
  std::string text() const;
  /// An integer from low to high.
  std::int64_t integer(std::int64_t low, std::int64_t high) const;

  [[noreturn]] void refuse(std::string_view rule) const;
  void warn(std::string_view what) const;
  /// Whether a repairable fault is an error.
  bool strict() const { return reading_->strict; }
  /// Counts bounded elements; refuses if there are too many.
  void count(std::size_t SceneLimits::*what, std::size_t count = 1) const;
  /// Counts its elements as the colliders of one body.
  void count_parts() const;
  /// Runs `call`; puts the place in front of its errors.
  void guard(const std::function<void()>& call) const;

 private:
  const json* value_;
  Reading* reading_;
  const Place* parent_ = nullptr;
  std::string_view key_;
  std::size_t index_ = 0;
};

/// The start of a value, for messages.
std::string excerpt(const json& value);
/// Parses a document within kMaxSceneBytes and kMaxSceneDepth.
json parse_document(std::string_view text, std::string_view file);

}  // namespace tandem::scene_files
