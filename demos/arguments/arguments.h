// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Command lines of all programs: demos, tools and benchmarks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/parse_number.h"

namespace tandem::demos {

/// An invalid command line; what() names rule and value.
class UsageError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// @throws UsageError "<option> must be <rule>, is '<value>'"
[[noreturn]] void refuse(std::string_view option, std::string_view value, std::string_view rule);
/// "unknown <kind> '<name>'; did you mean '<the nearest known name>'?"
/// @param prefix  of `name` but not of the known names   @param else_hint  if none is near
std::string unknown(std::string_view kind, std::string_view name,
                    std::span<const std::string_view> known, std::string_view prefix = {},
                    std::string_view else_hint = "--help-all lists what there is");

template <class Number>
Number number(std::string_view option, std::string_view text, Number low, Number high,
              std::string_view rule) {
  Number value{};
  // Written so that NaN is refused too.
  const bool good = pbd::detail::parse_number(text, value) && value >= low && value <= high;
  if (!good) refuse(option, text, rule);
  return value;
}

/// The items of a comma-separated list; an empty list has one empty item.
std::vector<std::string_view> items_of(std::string_view list);

/// An option that was given, and its value. An option whose value is not read is a switch.
class Argument {
 public:
  Argument(std::string_view name, std::optional<std::string_view> inline_value,
           std::span<const std::string_view>& rest)
      : name_(name), inline_value_(inline_value), rest_(rest) {}

  std::string_view name() const { return name_; }
  std::string_view value();
  /// An optional value: the next word is the value unless it is an option.
  std::string_view value_or(std::string_view fallback);
  /// A value that is not empty.
  std::string text();
  template <class Number>
  Number number(Number low, Number high, std::string_view rule) {
    return demos::number(name_, value(), low, high, rule);
  }
  /// An optional "PORT" or "ADDRESS:PORT" to serve at; 0, also without a value, is any port.
  /// @param address  set if one is given; [..] is left out of an IPv6 one
  std::uint16_t port(std::string& address);
  /// Calls visit(key, value) for each item of "key=value,key"; value may be empty.
  /// @throws UsageError if a key is not in `known`
  void items(std::span<const std::string_view> known,
             const std::function<void(std::string_view key, std::string_view value)>& visit);
  /// Call after reading the option. @throws UsageError if a switch was given a value
  void finish() const;

 private:
  std::string_view name_;
  std::optional<std::string_view> inline_value_;
  std::span<const std::string_view>& rest_;  ///< of the command line
};

struct Option {
  std::string_view name;
  std::function<void(Argument&)> read;
};

/// Reads a command line: "--name value" and "--name=value" are the same.
/// @param word  takes words without a dash; without it they are refused
/// @throws UsageError
void read_arguments(std::span<const std::string_view> words, const std::vector<Option>& options,
                    const std::function<void(std::string_view)>& word = nullptr);

/// The last part of argv[0].
std::string program_name(const char* path);

/// The main() of a program. Answers --help, -h, --help-all and --version. Returns and prints: the
/// exit code of `run`; 2 for an invalid command line; 1 for any other exception.
/// @param run  takes the words after the program's name
/// @param usage_of_all  for --help-all; empty = same as `usage`
int program_main(int argc, char** argv, std::string_view usage,
                 const std::function<int(std::span<const std::string_view> words)>& run,
                 std::string_view usage_of_all = {});

/// Checks before a long run that results can be written. @throws UsageError
void require_writable_file(std::string_view option, const std::string& path);
/// The same check for a folder, which is created if missing.
void require_writable_folder(std::string_view option, const std::string& path);

}  // namespace tandem::demos
