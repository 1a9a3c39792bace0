// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>

namespace tandem::demos {

/// What a user is asked for where `for_owner_alone` is false.
#ifdef _WIN32
inline constexpr std::string_view kForOwnerAlone =
    "a file that nobody else can read or write (icacls FILE /inheritance:r /grant:r %USERNAME%:F)";
#else
inline constexpr std::string_view kForOwnerAlone =
    "a file that nobody else can read or write (chmod 600)";
#endif

/// Whether nobody but the owner of a file can read or write it; on Windows nobody but this user,
/// the system and its administrators. False where that cannot be found out.
bool for_owner_alone(const std::string& path);

/// Makes a file for its owner alone, never over another one.
/// @throws std::system_error where it cannot be written
void write_for_owner_alone(const std::string& path, std::string_view text);

}  // namespace tandem::demos
