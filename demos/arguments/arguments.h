// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The command lines of all programs: demos, tools and benchmarks.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/parse_number.h"

namespace tandem::demos {

/// A command line that cannot be understood; what() says what must be and what is.
class UsageError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// @throws UsageError "<option> must be <rule>, is '<value>'"
[[noreturn]] void refuse(std::string_view option, std::string_view value, std::string_view rule);
/// "unknown <kind> '<name>'; did you mean '<the nearest that is known>'?"
/// @param prefix  of the name, which what is known does not have   @param else_hint  where none is
/// near
std::string unknown(std::string_view kind, std::string_view name,
                    std::span<const std::string_view> known, std::string_view prefix = {},
                    std::string_view else_hint = "--help-all lists what there is");

template <class Number>
Number number(std::string_view option, std::string_view text, Number low, Number high,
              std::string_view rule) {
  Number value{};
  // Written so that NaN is refused as well.
  const bool good = pbd::detail::parse_number(text, value) && value >= low && value <= high;
  if (!good) refuse(option, text, rule);
  return value;
}

/// The items of a list with commas between them; an empty one has one item, which is empty.
std::vector<std::string_view> items_of(std::string_view list);

/// An option that was given, and the value that belongs to it. Without a call of any of these it is
/// a switch, which takes no value.
class Argument {
 public:
  Argument(std::string_view name, std::optional<std::string_view> inline_value,
           std::span<const std::string_view>& rest)
      : name_(name), inline_value_(inline_value), rest_(rest) {}

  std::string_view name() const { return name_; }
  std::string_view value();
  /// A value that may be left out: what follows is one where it is no option.
  std::string_view value_or(std::string_view fallback);
  /// A value that is not empty.
  std::string text();
  template <class Number>
  Number number(Number low, Number high, std::string_view rule) {
    return demos::number(name_, value(), low, high, rule);
  }
  /// Calls visit(key, value) for each item of "key=value,key"; value is empty where there is none.
  /// @throws UsageError where a key is none of `known`
  void items(std::span<const std::string_view> known,
             const std::function<void(std::string_view key, std::string_view value)>& visit);
  /// After the option was read. @throws UsageError where a switch was given a value
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
/// @param word  takes what begins with no dash; without it such a word is refused
/// @throws UsageError
void read_arguments(std::span<const std::string_view> words, const std::vector<Option>& options,
                    const std::function<void(std::string_view)>& word = nullptr);

/// The last part of argv[0].
std::string program_name(const char* path);

/// The main() of a program. Answers --help, -h, --help-all and --version. Returns the exit code:
/// that of `run`; 2 for a command line that cannot be understood, 1 for any other exception; both
/// are told.
/// @param run  takes the words after the program's name
/// @param usage_of_all  for --help-all; empty = there is no more than `usage`
int program_main(int argc, char** argv, std::string_view usage,
                 const std::function<int(std::span<const std::string_view> words)>& run,
                 std::string_view usage_of_all = {});

/// Before a long run, whether its results can be written. @throws UsageError
void require_writable_file(std::string_view option, const std::string& path);
/// The same for a folder, which is made where it is missing.
void require_writable_folder(std::string_view option, const std::string& path);

}  // namespace tandem::demos
