// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/shared_id.h"

#include <array>
#include <charconv>
#include <cinttypes>
#include <cstddef>
#include <cstdio>

namespace tandem::consensus {
namespace {

constexpr std::size_t kDigits = 32;
/// Positions of hyphens in the written form, the last one first.
constexpr std::array<std::size_t, 4> kHyphens = {23, 18, 13, 8};

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
  std::string digits(text);
  if (text.size() == kDigits + kHyphens.size()) {
    // From the back, so that the other positions stay valid.
    for (const std::size_t at : kHyphens) {
      if (digits[at] != '-') return std::nullopt;
      digits.erase(at, 1);
    }
  }
  if (digits.size() != kDigits) return std::nullopt;
  SharedId id;
  const char* const middle = digits.data() + kDigits / 2;
  const char* const end = digits.data() + kDigits;
  if (std::from_chars(digits.data(), middle, id.high, 16).ptr != middle) return std::nullopt;
  if (std::from_chars(middle, end, id.low, 16).ptr != end) return std::nullopt;
  return id;
}

std::string SharedId::to_string() const {
  std::array<char, kDigits + 1> digits{};
  std::snprintf(digits.data(), digits.size(), "%016" PRIx64 "%016" PRIx64, high, low);
  std::string text(digits.data());
  for (auto at = kHyphens.rbegin(); at != kHyphens.rend(); ++at) text.insert(*at, 1, '-');
  return text;
}

}  // namespace tandem::consensus
