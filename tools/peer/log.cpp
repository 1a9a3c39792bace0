// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/log.h"

#include <array>
#include <cerrno>
#include <system_error>

#include "arguments/terminal.h"

namespace tandem::demos {

namespace {

constexpr std::array<std::string_view, 4> kLevels = {"debug", "info", "warn", "error"};
// Not inherited by child processes, if the system supports that.
#ifdef _WIN32
constexpr const char* kAppend = "a";
#else
constexpr const char* kAppend = "ae";
#endif
constexpr std::size_t kLongestValue = 200;  // bytes of a value

std::string quoted_value(std::string_view value) {
  const bool cut = value.size() > kLongestValue;
  if (cut) value = value.substr(0, kLongestValue);
  bool plain = !value.empty() && !cut;
  std::string inside;
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte > 0x7e) {
      std::array<char, 5> code{};
      std::snprintf(code.data(), code.size(), "\\x%02x", static_cast<unsigned>(byte));
      inside += code.data();
      plain = false;
      continue;
    }
    if (c == '"' || c == '\\') inside += '\\';
    plain = plain && c != '"' && c != '\\' && c != '=' && c != ' ';
    inside += c;
  }
  if (cut) inside += "..";
  return plain ? inside : '"' + inside + '"';
}

std::string iso8601(std::chrono::system_clock::time_point time) {
  using namespace std::chrono;
  const auto midnight = floor<days>(time);
  const year_month_day date(midnight);
  const hh_mm_ss clock(floor<milliseconds>(time - midnight));
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", int(date.year()),
                unsigned(date.month()), unsigned(date.day()), int(clock.hours().count()),
                int(clock.minutes().count()), int(clock.seconds().count()),
                int(clock.subseconds().count()));
  return text.data();
}

}  // namespace

std::string_view to_string(Level level) { return kLevels[static_cast<std::size_t>(level)]; }

bool parse_level(std::string_view text, Level& level) {
  for (std::size_t i = 0; i < kLevels.size(); ++i) {
    if (kLevels[i] != text) continue;
    level = static_cast<Level>(i);
    return true;
  }
  return false;
}

Field::Field(std::string_view name, double number) : key(name) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", number);
  value = text.data();
}

std::string logfmt(std::chrono::system_clock::time_point time, Level level, std::string_view event,
                   std::initializer_list<Field> fields) {
  std::string out = "time=" + iso8601(time) + " level=" + std::string(to_string(level)) +
                    " event=" + std::string(event);
  for (const Field& field : fields) out += ' ' + field.key + '=' + quoted_value(field.value);
  return out;
}

Log::Log(const std::string& file, Level least, bool status)
    : file_(file.empty() ? nullptr : std::fopen(file.c_str(), kAppend)),
      least_(least),
      shows_status_(status && is_terminal(stderr)) {
  if (!file.empty() && file_ == nullptr) {
    throw std::system_error(errno, std::generic_category(), "log.file = " + file);
  }
}

Log::~Log() {
  if (!status_.empty()) std::fputs("\r\033[K", stderr);
  if (file_ != nullptr) std::fclose(file_);
}

void Log::line(Level level, std::string_view event, std::initializer_list<Field> fields) {
  if (level < least_) return;
  std::FILE* const out = file_ != nullptr ? file_ : stderr;
  std::string text = logfmt(std::chrono::system_clock::now(), level, event, fields) + '\n';
  if (file_ == nullptr && !status_.empty()) text = "\r\033[K" + text + status_;
  std::fputs(text.c_str(), out);
  std::fflush(out);
}

void Log::status(const std::string& text) {
  if (!shows_status_) return;
  status_ = text;
  std::fprintf(stderr, "\r%s\033[K", text.c_str());
  std::fflush(stderr);
}

}  // namespace tandem::demos
