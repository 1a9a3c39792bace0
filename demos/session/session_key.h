// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::demos {

using Key = std::array<std::uint8_t, 32>;

/// 64 hex digits; nothing where they are something else, or zero.
std::optional<Key> key_from_hex(std::string_view digits);

/// The key in a file: 64 hex digits, white space between them is passed over. Nobody but its owner
/// may have access to it.
/// @throws std::invalid_argument with what the file must be, without its name
Key read_session_key(const std::string& path);

/// The identity that a file keeps; where there is none yet `make` makes one, which is written
/// there, for its owner alone to read.
/// @throws std::invalid_argument as read_session_key, std::system_error where it cannot be written
Key keep_identity(const std::string& path, Key (*make)());

/// The bytes that a file has as hex digits; white space between them is passed over.
/// @throws std::invalid_argument with the rule that the file breaks, without its name
std::vector<std::byte> read_hex_file(const std::string& path);

/// Whether a host's name can only be this machine.
bool is_loopback(const std::string& host);

}  // namespace tandem::demos
