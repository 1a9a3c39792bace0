// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>

#include "tandem/pbd/token_bucket.h"

namespace tandem::net {

/// Limits messages and bytes of a member. Nine hundred bodies in full, 60 times a second, are 4400
/// datagrams and 5 MB a second.
class MemberBudget {
 public:
  static constexpr double kMessages = 16384.0;              // a second
  static constexpr double kBytes = 16.0 * 1024.0 * 1024.0;  // a second
  static constexpr double kMessagesAtOnce = 4096.0;
  static constexpr double kBytesAtOnce = 1024.0 * 1024.0;
  static constexpr const char* kReason = "sends more than a member may: 16384 messages or 16 MiB/s";

  /// Whether one more message may be accepted. Times in ns.
  bool admits(std::int64_t now) {
    return messages_.fill(now) ? bytes_.admits(now) : messages_.admits(now);
  }
  /// The same, but without counting a refusal.
  bool has(std::int64_t now) {
    const bool messages = messages_.fill(now);
    return bytes_.fill(now) && messages;
  }
  /// Charge one message.
  void spend(std::size_t bytes) {
    messages_.spend(1.0);
    bytes_.spend(static_cast<double>(bytes));
  }
  std::uint64_t refused() const { return messages_.refused() + bytes_.refused(); }
  /// Whether it was over its budget for as long as pbd::TokenBucket::kPatience.
  bool abused() const { return messages_.abused() || bytes_.abused(); }

 private:
  pbd::TokenBucket messages_{kMessages, kMessagesAtOnce};
  pbd::TokenBucket bytes_{kBytes, kBytesAtOnce};
};

}  // namespace tandem::net
