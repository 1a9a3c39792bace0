// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Globally unique identifier (128 bits) of a shared body: the same at every peer, whatever its
/// index in a peer's world. Ordered like its written form, so that sorting gives the same order
/// everywhere. All zeros = none.
/// @par Thread safety  A value: safe.
struct TANDEM_API SharedId {
  std::uint64_t high = 0;  ///< first 16 hexadecimal digits of the written form
  std::uint64_t low = 0;   ///< last 16

  bool valid() const { return high != 0 || low != 0; }
  friend auto operator<=>(const SharedId&, const SharedId&) = default;

  /// The id of a name: 128-bit FNV-1a of its bytes (offset basis 6c62272e07bb014262b821756295c58d,
  /// prime 2^88 + 13b, both hexadecimal), most significant half in `high`. The same on every
  /// machine. No protection against deliberate collisions.
  static SharedId from_name(std::string_view name);

  /// Reads the written form: 32 hexadecimal digits of either case, with hyphens after digits 8, 12,
  /// 16 and 20 or without any. Otherwise nullopt.
  static std::optional<SharedId> parse(std::string_view text);

  /// Written form in lower case, "01234567-89ab-cdef-0123-456789abcdef".
  std::string to_string() const;
};

}  // namespace tandem::consensus
