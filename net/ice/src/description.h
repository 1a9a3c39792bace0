// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tandem::ice {

/// What two peers exchange before they are connected: lines "tandem-ice 1", "ufrag TEXT", "pwd
/// TEXT", and a "candidate:..." for each address as in RFC 8839, Sec. 5.1.
struct Description {
  std::string ufrag;
  std::string password;
  std::vector<std::string> candidates;  ///< beginning with "candidate:"
};

std::string encode(const Description& description);

/// @throws std::invalid_argument unless the untrusted text has this form and its parts are within
/// bounds
Description parse_description(std::string_view text);

}  // namespace tandem::ice
