// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tandem/pbd/validate.h"

namespace tandem::scene_files {

std::string excerpt(const json& value) {
  if (value.is_array() && value.size() > 8) return "[...]";
  if (value.is_object()) return "{...}";
  for (const json& item : value) {
    if (item.is_structured()) return "[...]";
  }
  std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 60) + "...";
  return text;
}

std::string Place::pointer() const {
  if (parent_ == nullptr) return {};
  std::string out = parent_->pointer() + '/';
  if (key_.empty()) return out + std::to_string(index_);
  for (const char c : key_) {
    if (c == '~' || c == '/') {
      out += c == '~' ? "~0" : "~1";
    } else {
      out += c;
    }
  }
  return out;
}

void Place::refuse(std::string_view rule) const {
  std::string where = pointer();
  if (where.empty()) where = "document";
  throw SceneFileError(
      pbd::detail::must_be(std::string(reading_->file) + ": " + where, rule, excerpt(*value_)));
}

void Place::warn(std::string_view what) const {
  reading_->warnings.push_back(pointer() + ": " + std::string(what));
}

void Place::count(std::size_t SceneLimits::*what, std::size_t count) const {
  if (const std::string rule = reading_->limits.add(what, count); !rule.empty()) refuse(rule);
}

void Place::count_parts() const {
  if (const std::string rule = reading_->limits.parts(size()); !rule.empty()) refuse(rule);
}

void Place::guard(const std::function<void()>& call) const {
  try {
    call();
  } catch (const SceneFileError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw SceneFileError(std::string(reading_->file) + ": " + pointer() + ": " + error.what());
  }
}

Place Place::at(const char* key) const {
  if (!value_->is_object()) refuse("an object");
  const auto found = value_->find(key);
  if (found == value_->end()) refuse("an object with \"" + std::string(key) + '"');
  Place place(*found, *reading_);
  place.parent_ = this;
  place.key_ = found.key();
  return place;
}

Place Place::at(std::size_t index) const {
  if (index >= size()) refuse("an array of more than " + std::to_string(index) + " values");
  Place place((*value_)[index], *reading_);
  place.parent_ = this;
  place.index_ = index;
  return place;
}

std::size_t Place::size() const {
  if (!value_->is_array()) refuse("an array");
  return value_->size();
}

Place Place::pick(const Place& index) const {
  if (size() == 0) index.refuse("the number of one of " + pointer() + ", which has none");
  return at(static_cast<std::size_t>(index.integer(0, static_cast<std::int64_t>(size()) - 1)));
}

double Place::number() const {
  if (value_->is_number()) return value_->get<double>();
  if (*value_ == "Infinity") return std::numeric_limits<double>::infinity();
  if (*value_ == "-Infinity") return -std::numeric_limits<double>::infinity();
  refuse("a number, \"Infinity\" or \"-Infinity\"");
}

std::string Place::text() const {
  if (!value_->is_string()) refuse("a string");
  return value_->get<std::string>();
}

std::int64_t Place::integer(std::int64_t low, std::int64_t high) const {
  const std::string rule =
      "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  if (!value_->is_number_integer()) refuse(rule);
  if (value_->is_number_unsigned() &&
      value_->get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()}) {
    refuse(rule);
  }
  const auto number = value_->get<std::int64_t>();
  if (number < low || number > high) refuse(rule);
  return number;
}

/// Depth of nested arrays and objects in a JSON text.
int depth_of(std::string_view text) {
  int depth = 0;
  int most = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted) {
      if (c == '\\') ++i;
    } else if (c == '[' || c == '{') {
      most = std::max(most, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return most;
}

json parse_document(std::string_view text, std::string_view file) {
  const auto refuse = [file](const std::string& what, std::string_view rule,
                             std::string_view value) {
    throw SceneFileError(pbd::detail::must_be(std::string(file) + ": " + what, rule, value));
  };
  if (text.size() > kMaxSceneBytes) {
    refuse("size", "at most " + std::to_string(kMaxSceneBytes) + " bytes",
           std::to_string(text.size()));
  }
  // Before parsing: with a callback the parser scans an array again at each object in it.
  const int depth = depth_of(text);
  if (depth > kMaxSceneDepth) {
    refuse("depth", "at most " + std::to_string(kMaxSceneDepth), std::to_string(depth));
  }
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    throw SceneFileError(std::string(file) + ": text must be JSON: " + error.what());
  }
}

}  // namespace tandem::scene_files
