// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>

namespace tandem::demos {

/// The advice to users if `for_owner_alone` is false.
#ifdef _WIN32
inline constexpr std::string_view kForOwnerAlone =
    "a file that nobody else can read or write (icacls FILE /inheritance:r /grant:r %USERNAME%:F)";
#else
inline constexpr std::string_view kForOwnerAlone =
    "a file that nobody else can read or write (chmod 600)";
#endif

/// True if only the owner can read or write a file; on Windows only this user, the system and its
/// administrators. False if unknown.
bool for_owner_alone(const std::string& path);

/// Creates a file for its owner alone, never overwriting one.
/// @throws std::system_error if it cannot be written
void write_for_owner_alone(const std::string& path, std::string_view text);

}  // namespace tandem::demos
