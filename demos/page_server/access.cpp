// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "page_server/access.h"

#ifndef _WIN32
#include <sys/random.h>
#endif

#include <algorithm>
#include <array>
#include <random>
#include <stdexcept>

namespace tandem::page_server {

namespace {

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned>(a[i] ^ b[i]);
  return difference == 0;
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
#ifdef _WIN32
  std::random_device random;  // rand_s, the system's
  for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
#else
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = getrandom(bytes.data() + filled, bytes.size() - filled, 0);
    if (got <= 0) throw std::runtime_error("the system has no random numbers");
    filled += static_cast<std::size_t>(got);
  }
#endif
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) {
    token += kDigits[byte >> 4];
    token += kDigits[byte & 15];
  }
  return token;
}

std::optional<std::string_view> below(std::string_view token, std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  const std::size_t length = token.size();
  if (path.size() < length + 2 || path[0] != '/' || path[length + 1] != '/') return std::nullopt;
  if (!same_secret(path.substr(1, length), token)) return std::nullopt;
  return path.substr(length + 2);
}

bool lacks_slash(std::string_view token, std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  return path.size() == token.size() + 1 && path[0] == '/' && same_secret(path.substr(1), token);
}

bool is_name_of(std::string_view host, const boost::asio::ip::address& address,
                std::uint16_t port) {
  if (host.empty()) return false;
  const std::size_t colon = host.rfind(':');
  const bool bare = colon == std::string_view::npos || host.back() == ']';
  const std::string digits = std::to_string(port);
  if (bare ? digits != "80" : host.substr(colon + 1) != digits) return false;
  std::string name(bare ? host : host.substr(0, colon));
  if (name == "localhost") return address.is_loopback() || address.is_unspecified();
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') {
    name = name.substr(1, name.size() - 2);
  }
  // A host name that resolves to this address may be a third party's.
  boost::system::error_code error;
  const boost::asio::ip::address named = boost::asio::ip::make_address(name, error);
  return !error && (named == address || address.is_unspecified());
}

bool Allowance::take(Clock::time_point now, double amount) {
  const std::chrono::duration<double> passed = now - last_;
  last_ = now;
  left_ = std::min(per_s_, left_ + per_s_ * passed.count());
  if (left_ < amount) return false;
  left_ -= amount;
  return true;
}

}  // namespace tandem::page_server
