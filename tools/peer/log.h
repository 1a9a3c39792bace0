// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>

namespace tandem::demos {

enum class Level : std::uint8_t { Debug, Info, Warn, Error };
std::string_view to_string(Level level);
bool parse_level(std::string_view text, Level& level);

struct Field {
  Field(std::string_view name, std::string_view text) : key(name), value(text) {}
  Field(std::string_view name, const char* text) : key(name), value(text) {}
  Field(std::string_view name, double number);
  Field(std::string_view name, std::uint64_t number) : key(name), value(std::to_string(number)) {}
  std::string key;
  std::string value;
};

/// A line of logfmt without its end: time, level, event, then the fields. Values may contain remote
/// input: control characters and bytes above 126 become \xNN, and values are cut to 200 bytes.
std::string logfmt(std::chrono::system_clock::time_point time, Level level, std::string_view event,
                   std::initializer_list<Field> fields);

/// Writes lines to a file or to standard error, with a status line below on a terminal.
/// @par Thread safety  One object: one thread at a time.
class Log {
 public:
  /// @param file  appended to; "" = standard error     @param status  allow the status line
  /// @throws std::system_error if the file cannot be opened
  Log(const std::string& file, Level least, bool status);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void line(Level level, std::string_view event, std::initializer_list<Field> fields = {});
  /// Replaces the status line; no effect without a terminal.
  void status(const std::string& text);
  bool shows_status() const { return shows_status_; }

 private:
  std::FILE* file_;  ///< null: standard error
  Level least_;
  bool shows_status_;
  std::string status_;
};

}  // namespace tandem::demos
