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

/// 64 hex digits; nothing if they are invalid or zero.
std::optional<Key> key_from_hex(std::string_view digits);

/// Reads a key from a file: 64 hex digits, white space is skipped. Only the owner may have access
/// to the file.
/// @throws std::invalid_argument with the rule for the file, without its name
Key read_session_key(const std::string& path);

/// The identity in a file. A missing file is created with a new identity from `make`, readable by
/// its owner alone.
/// @throws std::invalid_argument as read_session_key, std::system_error if it cannot be written
Key keep_identity(const std::string& path, Key (*make)());

/// Reads a file of hex digits; white space is skipped.
/// @throws std::invalid_argument with the rule that the file breaks, without its name
std::vector<std::byte> read_hex_file(const std::string& path);

/// The same of a file to which only the owner may have access.
/// @throws std::invalid_argument as read_hex_file
std::vector<std::byte> read_secret_hex_file(const std::string& path);

/// True if a host's name can only be this machine.
bool is_loopback(const std::string& host);

}  // namespace tandem::demos
