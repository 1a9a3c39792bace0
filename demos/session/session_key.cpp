// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/session_key.h"

#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace tandem::demos {

std::optional<Key> key_from_hex(std::string_view digits) {
  Key key{};
  if (digits.size() != 2 * key.size()) return std::nullopt;
  bool zero = true;
  for (std::size_t i = 0; i < key.size(); ++i) {
    const char* const from = digits.data() + 2 * i;
    const std::from_chars_result read = std::from_chars(from, from + 2, key[i], 16);
    if (read.ec != std::errc{} || read.ptr != from + 2) return std::nullopt;
    zero = zero && key[i] == 0;
  }
  if (zero) return std::nullopt;
  return key;
}

Key read_session_key(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::invalid_argument("a file that can be read");
  using std::filesystem::perms;
  constexpr perms kOthers = perms::group_all | perms::others_all;
  std::error_code ignored;
  if ((std::filesystem::status(path, ignored).permissions() & kOthers) != perms::none) {
    throw std::invalid_argument("a file that nobody else can read or write (chmod 600)");
  }
  std::string digits;
  for (char c = 0; digits.size() <= 2 * sizeof(Key) && in.get(c);) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) digits += c;
  }
  const std::optional<Key> key = key_from_hex(digits);
  if (!key) throw std::invalid_argument("a file with 64 hex digits, not all 0, see tandem-key");
  return *key;
}

bool is_loopback(const std::string& host) {
  if (host == "localhost" || host == "::1") return true;
  // A name may begin like an address.
  return host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos;
}

}  // namespace tandem::demos
