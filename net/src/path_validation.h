// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "address.h"

namespace tandem::net {

/// Whether a peer receives at the address from which its packet came, and nowhere else: it is
/// challenged there, under the keys of its connection. docs/protocol.md ("Moving") says what an
/// attacker who copies packets gains. Times in ns.
class PathValidation {
 public:
  static constexpr std::int64_t kLife = 3'000'000'000;  ///< without an answer by then it has failed
  static constexpr std::int64_t kResend = 100'000'000;  ///< doubled each time
  /// RFC 9000, Sec. 8.1, has three; an answer to a challenge from there is the third.
  static constexpr std::size_t kAmplification = 2;

  /// @param sequence  of the packet that came from there
  /// @param token  random, never 0: only a receiver can echo it
  PathValidation(const Address& address, std::uint64_t sequence, std::uint64_t token,
                 std::int64_t now)
      : address_(address), sequence_(sequence), token_(token), began_(now), due_(now) {}

  const Address& address() const { return address_; }
  std::uint64_t token() const { return token_; }
  /// A packet with this number from the old address shows that the peer has not moved.
  bool refuted_by(std::uint64_t sequence) const { return sequence >= sequence_; }

  /// This many bytes came from there.
  void came(std::size_t bytes) { allowance_ += kAmplification * bytes; }
  /// Whether a challenge of this size is due there.
  bool due(std::size_t bytes, std::int64_t now) const {
    return !answered_ && now >= due_ && bytes <= allowance_;
  }
  void sent(std::size_t bytes, std::int64_t now) {
    allowance_ -= std::min(bytes, allowance_);
    due_ = now + gap_;
    gap_ *= 2;
    ++questions_;
  }
  bool is_first() const { return questions_ == 0; }
  void answered() { answered_ = true; }
  /// @param patience  time within which the original would have come, were this a copy
  bool has_succeeded(std::int64_t patience, std::int64_t now) const {
    return answered_ && now - began_ >= patience;
  }
  bool has_failed(std::int64_t now) const { return !answered_ && now - began_ > kLife; }
  /// Next time at which one of these may change, if nothing comes from there before.
  std::int64_t next_due(std::size_t bytes, std::int64_t patience) const {
    if (answered_) return began_ + patience;
    return bytes <= allowance_ ? due_ : began_ + kLife + 1;
  }

 private:
  Address address_;
  std::uint64_t sequence_;
  std::uint64_t token_;
  std::int64_t began_;
  std::int64_t due_;
  std::int64_t gap_ = kResend;
  std::size_t allowance_ = 0;  // bytes that may still be sent there
  std::size_t questions_ = 0;
  bool answered_ = false;
};

/// A third peer claims that a peer is elsewhere. While the old address is silent, the peer is
/// challenged there. Its answer comes from a new address, which is then validated like any other.
class PathRumour {
 public:
  static constexpr std::int64_t kQuiet =
      PathValidation::kResend;  ///< packets come more often while stepping

  PathRumour(const Address& address, std::int64_t now)
      : address_(address), due_(now), end_(now + PathValidation::kLife) {}

  const Address& address() const { return address_; }
  bool due(std::int64_t now) const { return now >= due_; }
  std::int64_t next_due() const { return due_; }
  void asked(std::int64_t now) {
    due_ = now + gap_;
    gap_ *= 2;
  }
  bool is_over(std::int64_t now) const { return now > end_; }

 private:
  Address address_;
  std::int64_t due_;
  std::int64_t end_;
  std::int64_t gap_ = PathValidation::kResend;
};

}  // namespace tandem::net
