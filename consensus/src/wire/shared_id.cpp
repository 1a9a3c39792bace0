// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/shared_id.h"

#include <array>
#include <cstddef>

namespace tandem::consensus {
namespace {

constexpr std::size_t kDigits = 32;
constexpr std::size_t kHyphens = 4;

/// Whether the written form has a hyphen in front of digit `digit`.
bool hyphen_before(std::size_t digit) {
  return digit == 8 || digit == 12 || digit == 16 || digit == 20;
}

/// Value of a hexadecimal digit, or -1.
int digit_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// id * (2^88 + 0x13b) modulo 2^128, from 32-bit pieces: no 128-bit type needed.
SharedId times_fnv_prime(SharedId id) {
  constexpr std::uint64_t kSmall = 0x13b;
  constexpr std::uint64_t kMask = 0xffffffffu;
  const std::uint64_t low_part = (id.low & kMask) * kSmall;
  const std::uint64_t mid_part = (id.low >> 32) * kSmall + (low_part >> 32);
  SharedId product;
  product.low = (mid_part << 32) | (low_part & kMask);
  product.high = id.high * kSmall + (mid_part >> 32) + (id.low << 24);
  return product;
}

}  // namespace

SharedId SharedId::from_name(std::string_view name) {
  SharedId id{0x6c62272e07bb0142u, 0x62b821756295c58du};
  for (const char c : name) {
    id.low ^= static_cast<unsigned char>(c);
    id = times_fnv_prime(id);
  }
  return id;
}

std::optional<SharedId> SharedId::parse(std::string_view text) {
  const bool hyphens = text.size() == kDigits + kHyphens;
  if (!hyphens && text.size() != kDigits) return std::nullopt;
  SharedId id;
  std::size_t at = 0;
  for (std::size_t digit = 0; digit < kDigits; ++digit) {
    if (hyphens && hyphen_before(digit) && text[at++] != '-') return std::nullopt;
    const int value = digit_value(text[at++]);
    if (value < 0) return std::nullopt;
    std::uint64_t& half = digit < kDigits / 2 ? id.high : id.low;
    half = (half << 4) | static_cast<std::uint64_t>(value);
  }
  return id;
}

std::string SharedId::to_string() const {
  constexpr std::array<char, 17> kHex = {"0123456789abcdef"};
  std::string text;
  text.reserve(kDigits + kHyphens);
  for (std::size_t digit = 0; digit < kDigits; ++digit) {
    if (hyphen_before(digit)) text.push_back('-');
    const std::uint64_t half = digit < kDigits / 2 ? high : low;
    const std::size_t shift = 60 - 4 * (digit % (kDigits / 2));
    text.push_back(kHex[(half >> shift) & 0xf]);
  }
  return text;
}

}  // namespace tandem::consensus
