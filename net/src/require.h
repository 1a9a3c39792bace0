// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <string>

#include "tandem/net/membership.h"
#include "tandem/pbd/validate.h"

namespace tandem::net {

/// Throws std::invalid_argument "<owner>: <field> must be <rule>, is <value>" unless `ok`.
inline void require(bool ok, const char* owner, const char* field, const std::string& value,
                    const char* rule) {
  if (ok) return;
  pbd::detail::refuse(std::string(owner) + ": " + field, rule, value.empty() ? "empty" : value);
}

template <class Integer>
void require(bool ok, const char* owner, const char* field, Integer value, const char* rule) {
  if (!ok) require(false, owner, field, std::to_string(value), rule);
}

/// Membership options that both transports share.
template <class Options>
void require_credentials(const Options& options, const char* owner) {
  const std::string given = "given";
  require(options.certificate.empty() || options.certificate.size() == kCertificateBytes, owner,
          "certificate", options.certificate.size(), "121 bytes long");
  require(options.certificate.empty() || options.organiser, owner, "certificate", given,
          "none without an organiser");
  require(!options.organiser || options.identity, owner, "organiser", given,
          "none without an identity");
  if (!is_derived(options.self)) return;
  require(options.identity && derived_id(public_key(*options.identity)) == options.self, owner,
          "self", options.self, "below 2^63, or derived from identity");
}

/// Time options that both transports share.
template <class Options>
void require_times(const Options& options, const char* owner) {
  using std::chrono::milliseconds;
  const auto period = [owner](milliseconds value, milliseconds least, const char* field,
                              const char* rule) {
    require(value >= least && value <= std::chrono::hours(1), owner, field, value.count(), rule);
  };
  period(options.idle_timeout, milliseconds(40), "idle_timeout", "in [40 ms, 1 h]");
  period(options.backoff_min, milliseconds(1), "backoff_min", "in [1 ms, 1 h]");
  period(options.backoff_max, options.backoff_min, "backoff_max", "in [backoff_min, 1 h]");
  period(options.drop_hold, milliseconds(0), "drop_hold", "in [0, 1 h]");
  require(options.flush_timeout >= milliseconds(0) && options.flush_timeout <= milliseconds(10000),
          owner, "flush_timeout", options.flush_timeout.count(), "in [0, 10 s]");
}

}  // namespace tandem::net
