// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/session_key.h"

#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "session/key_file.h"

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
  if (!for_owner_alone(path)) throw std::invalid_argument(std::string(kForOwnerAlone));
  std::string digits;
  for (char c = 0; digits.size() <= 2 * sizeof(Key) && in.get(c);) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) digits += c;
  }
  const std::optional<Key> key = key_from_hex(digits);
  if (!key) throw std::invalid_argument("a file with 64 hex digits, not all 0, see tandem-key");
  return *key;
}

Key keep_identity(const std::string& path, Key (*make)()) {
  if (std::filesystem::exists(path)) return read_session_key(path);
  const Key made = make();
  std::string digits;
  for (const std::uint8_t byte : made) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    digits += kDigits[byte >> 4];
    digits += kDigits[byte & 15];
  }
  digits += '\n';
  write_for_owner_alone(path, digits);
  return made;
}

std::vector<std::byte> read_hex_file(const std::string& path) {
  constexpr std::size_t kLongest = 16384;
  std::ifstream in(path);
  if (!in) throw std::invalid_argument("a file that can be read");
  std::string digits;
  for (char c = 0; digits.size() < kLongest && in.get(c);) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) digits += c;
  }
  std::vector<std::byte> out(digits.size() / 2);
  bool good = !digits.empty() && digits.size() % 2 == 0 && digits.size() < kLongest;
  for (std::size_t i = 0; good && i < out.size(); ++i) {
    std::uint8_t value = 0;
    const char* const from = digits.data() + 2 * i;
    good = std::from_chars(from, from + 2, value, 16).ptr == from + 2;
    out[i] = static_cast<std::byte>(value);
  }
  if (!good) throw std::invalid_argument("a file with hex digits, two for each byte");
  return out;
}

std::vector<std::byte> read_secret_hex_file(const std::string& path) {
  // A missing file is what read_hex_file says it is.
  if (std::filesystem::exists(path) && !for_owner_alone(path)) {
    throw std::invalid_argument(std::string(kForOwnerAlone));
  }
  return read_hex_file(path);
}

bool is_loopback(const std::string& host) {
  if (host == "localhost" || host == "::1") return true;
  // A host name may begin with "127." too.
  return host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos;
}

}  // namespace tandem::demos
