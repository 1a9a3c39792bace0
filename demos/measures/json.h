// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::demos {

/// Writes one JSON text (RFC 8259), indented. Numbers keep every bit; non-finite ones become null.
/// Misplaced keys are asserted, not checked.
class JsonWriter {
 public:
  JsonWriter& begin_object() { return open('{'); }
  JsonWriter& end_object() { return close('}'); }
  JsonWriter& begin_array() { return open('['); }
  JsonWriter& end_array() { return close(']'); }
  JsonWriter& key(std::string_view name);

  JsonWriter& value(double number);
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& value(bool truth) { return raw(truth ? "true" : "false"); }
  template <std::integral Integer>
  requires(!std::same_as<Integer, bool>) JsonWriter& value(Integer number) {
    return raw(std::to_string(number));
  }
  JsonWriter& null() { return raw("null"); }

  template <class Value>
  JsonWriter& field(std::string_view name, const Value& content) {
    key(name);
    return value(content);
  }
  JsonWriter& null_field(std::string_view name) {
    key(name);
    return null();
  }

  /// The text so far, complete once all brackets are closed.
  const std::string& text() const { return text_; }

 private:
  JsonWriter& open(char bracket);
  JsonWriter& close(char bracket);
  JsonWriter& raw(std::string_view token);
  void before_value();
  void new_line();

  std::string text_;
  std::vector<bool> filled_;  ///< of each open bracket, outermost first: true if not empty
  bool after_key_ = false;
};

/// The text in double quotes, escaped. Invalid UTF-8 becomes U+FFFD.
std::string json_string(std::string_view text);

}  // namespace tandem::demos
