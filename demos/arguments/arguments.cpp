// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "arguments/arguments.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <utility>

#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

std::string in_quotes(std::string_view text) { return '\'' + std::string(text) + '\''; }

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

void refuse(std::string_view option, std::string_view value, std::string_view rule) {
  throw UsageError(pbd::detail::must_be(option, rule, in_quotes(value)));
}

std::string unknown(std::string_view kind, std::string_view name,
                    std::span<const std::string_view> known, std::string_view prefix,
                    std::string_view else_hint) {
  const std::string text = "unknown " + std::string(kind) + ' ' + in_quotes(name);
  name.remove_prefix(prefix.size());
  const auto distance = [name](std::string_view other) { return edit_distance(name, other); };
  const auto nearest = std::min_element(known.begin(), known.end(),
                                        [&](auto a, auto b) { return distance(a) < distance(b); });
  // Up to a third of the letters may be wrong; beyond that it is another word.
  if (nearest != known.end() && distance(*nearest) <= std::max<std::size_t>(1, name.size() / 3)) {
    return text + "; did you mean " + in_quotes(std::string(prefix).append(*nearest)) + '?';
  }
  return text + "; " + std::string(else_hint);
}

std::vector<std::string_view> items_of(std::string_view list) {
  std::vector<std::string_view> items;
  while (true) {
    const std::size_t comma = list.find(',');
    items.push_back(list.substr(0, comma));
    if (comma == std::string_view::npos) return items;
    list.remove_prefix(comma + 1);
  }
}

std::string_view Argument::value() {
  if (inline_value_) return *std::exchange(inline_value_, std::nullopt);
  if (rest_.empty()) throw UsageError(std::string(name_) + " needs a value");
  const std::string_view value = rest_.front();
  rest_ = rest_.subspan(1);
  return value;
}

std::string_view Argument::value_or(std::string_view fallback) {
  const bool follows = !rest_.empty() && !rest_.front().empty() && !rest_.front().starts_with("--");
  return inline_value_ || follows ? value() : fallback;
}

std::string Argument::text() {
  const std::string_view text = value();
  if (text.empty()) throw UsageError(std::string(name_) + " must not be empty");
  return std::string(text);
}

std::uint16_t Argument::port(std::string& address) {
  std::string_view text = value_or("0");
  if (const std::size_t colon = text.rfind(':'); colon != std::string_view::npos) {
    std::string_view before = text.substr(0, colon);
    text.remove_prefix(colon + 1);
    if (before.starts_with('[') && before.ends_with(']')) {
      before = before.substr(1, before.size() - 2);
    }
    if (before.empty()) refuse(name_, name_, "PORT or ADDRESS:PORT");
    address = before;
  }
  return demos::number(name_, text, std::uint16_t{0}, std::uint16_t{65535},
                       "a port from 0 (any) to 65535");
}

void Argument::items(
    std::span<const std::string_view> known,
    const std::function<void(std::string_view key, std::string_view value)>& visit) {
  for (const std::string_view item : items_of(value())) {
    const std::size_t equals = item.find('=');
    const std::string_view key = item.substr(0, equals);
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw UsageError(unknown("item of " + std::string(name_), key, known));
    }
    visit(key, equals == std::string_view::npos ? std::string_view() : item.substr(equals + 1));
  }
}

void Argument::finish() const {
  if (inline_value_) throw UsageError(std::string(name_) + " takes no value");
}

void read_arguments(std::span<const std::string_view> words, const std::vector<Option>& options,
                    const std::function<void(std::string_view)>& word) {
  while (!words.empty()) {
    const std::string_view first = words.front();
    words = words.subspan(1);
    if (!first.starts_with('-') && word) {
      word(first);
      continue;
    }
    if (!first.starts_with('-')) {
      throw UsageError("unexpected word " + in_quotes(first) + "; options begin with --");
    }
    const std::size_t equals = first.find('=');
    const std::string_view name = first.substr(0, equals);
    const auto option = std::find_if(options.begin(), options.end(),
                                     [&](const Option& o) { return o.name == name; });
    if (option == options.end()) {
      std::vector<std::string_view> known{"--help", "--help-all", "--version"};
      for (const Option& o : options) known.push_back(o.name);
      throw UsageError(unknown("option", name, known));
    }
    Argument argument(
        option->name,
        equals == std::string_view::npos ? std::nullopt : std::optional(first.substr(equals + 1)),
        words);
    option->read(argument);
    argument.finish();
  }
}

std::string program_name(const char* path) {
  const std::string_view whole(path);
  return std::string(whole.substr(whole.rfind('/') + 1));
}

int program_main(int argc, char** argv, std::string_view usage,
                 const std::function<int(std::span<const std::string_view> words)>& run,
                 std::string_view usage_of_all) {
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  const std::string program = program_name(argv[0]);
  for (const std::string_view word : words) {
    if (word == "--help" || word == "-h" || word == "--help-all") {
      const std::string_view text =
          word == "--help-all" && !usage_of_all.empty() ? usage_of_all : usage;
      std::fwrite(text.data(), 1, text.size(), stdout);
      return 0;
    }
    if (word == "--version") {
      std::printf("%s (Tandem) " TANDEM_VERSION "\n", program.c_str());
      return 0;
    }
  }
  try {
    return run(words);
  } catch (const UsageError& error) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
    return 1;
  }
}

void require_writable_file(std::string_view option, const std::string& path) {
  std::error_code ignored;
  const bool existed = std::filesystem::exists(path, ignored);
  if (!std::ofstream(path, std::ios::binary | std::ios::app)) {
    refuse(option, path, "a file that can be written");
  }
  if (!existed) std::filesystem::remove(path, ignored);
}

void require_writable_folder(std::string_view option, const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) refuse(option, path, "a folder that can be made or written");
}

}  // namespace tandem::demos
