// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "tandem/net/tcp.h"

namespace tandem::net {

/// The network thread's reports of dials and strangers, for the application's thread.
class TcpReport {
 public:
  void set_dials(std::vector<DialStatus> dials) {
    const std::lock_guard lock(mutex_);
    dials_ = std::move(dials);
  }
  /// Whether they are connected is in the table.
  std::vector<DialStatus> dials() const {
    const std::lock_guard lock(mutex_);
    return dials_;
  }

  /// Counts one of these, StrangerStatus::accepted and so on.
  void count(std::uint64_t StrangerStatus::*what, const std::string& reason = {}) {
    const std::lock_guard lock(mutex_);
    ++(strangers_.*what);
    if (!reason.empty()) strangers_.last_reason = reason;
  }
  StrangerStatus strangers() const {
    const std::lock_guard lock(mutex_);
    return strangers_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<DialStatus> dials_;
  StrangerStatus strangers_;
};

}  // namespace tandem::net
