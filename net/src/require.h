// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <stdexcept>
#include <string>

namespace tandem::net {

/// Throws std::invalid_argument "<owner>: <field> is <value>, must be <rule>" unless `ok`.
inline void require(bool ok, const char* owner, const char* field, const std::string& value,
                    const char* rule) {
  if (!ok) {
    throw std::invalid_argument(std::string(owner) + ": " + field + " is " + value + ", must be " +
                                rule);
  }
}

template <class Integer>
void require(bool ok, const char* owner, const char* field, Integer value, const char* rule) {
  if (!ok) require(false, owner, field, std::to_string(value), rule);
}

}  // namespace tandem::net
