// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tandem::ice {

/// What two peers tell each other before they have a way: lines "tandem-ice 1", "ufrag TEXT",
/// "pwd TEXT", and a "candidate:..." for each address as RFC 8839, Sec. 5.1, has it.
struct Description {
  std::string ufrag;
  std::string password;
  std::vector<std::string> candidates;  ///< beginning with "candidate:"
};

std::string encode(const Description& description);

/// @throws std::invalid_argument  it comes from outside, and must be of this form, with bounded
/// parts
Description parse_description(std::string_view text);

}  // namespace tandem::ice
