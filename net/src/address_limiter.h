// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "address.h"
#include "crypto.h"

namespace tandem::net {

/// Limits packets of unknown senders by address. Fixed memory: addresses share 1024 buckets by a
/// keyed hash, so that an attacker cannot choose whose bucket to empty. An IPv6 /64 is one address,
/// and so are all ports of a host.
class AddressLimiter {
 public:
  /// @param rate  per s and address  @param burst  at once  @param total  per s, of all addresses
  AddressLimiter(const crypto::Secret& key, double rate, double burst, double total)
      : key_(key), rate_(rate), burst_(burst), total_rate_(total), total_(total) {
    buckets_.fill({.tokens = burst, .at = 0});
  }

  bool allow(const Address& from, std::int64_t now) {
    Bucket& bucket = buckets_[index(from)];
    fill(bucket, now, rate_, burst_);
    if (bucket.tokens < 1.0) return false;
    // The total is checked last: an address over its own rate takes nothing from the others.
    Bucket all{.tokens = total_, .at = total_at_};
    fill(all, now, total_rate_, total_rate_);
    total_ = all.tokens;
    total_at_ = now;
    if (total_ < 1.0) return false;
    bucket.tokens -= 1.0;
    total_ -= 1.0;
    return true;
  }

 private:
  struct Bucket {
    double tokens = 0.0;
    std::int64_t at = 0;
  };

  static void fill(Bucket& bucket, std::int64_t now, double rate, double burst) {
    const double elapsed = static_cast<double>(std::max<std::int64_t>(0, now - bucket.at)) * 1e-9;
    bucket.tokens = std::min(burst, bucket.tokens + elapsed * rate);
    bucket.at = now;
  }

  std::size_t index(const Address& from) const {
    const bool whole = is_v4(from) || is_relayed(from) || is_path(from);
    const auto tag = crypto::mac16(key_, std::span(from.ip).first(whole ? 16 : 8));
    return (tag[0] | std::size_t{tag[1]} << 8) % buckets_.size();
  }

  crypto::Secret key_;
  double rate_;
  double burst_;
  double total_rate_;
  double total_;
  std::int64_t total_at_ = 0;
  std::array<Bucket, 1024> buckets_{};
};

}  // namespace tandem::net
