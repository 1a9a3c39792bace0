// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "address.h"

namespace tandem::nats {

/// Messages of the server between the client library's thread and the transport. The oldest is
/// dropped if they come faster than they are processed.
class Inbox {
 public:
  static constexpr std::size_t kMaxMessages = 4096;
  static constexpr std::size_t kMaxBytes = 2 * 1024 * 1024;

  enum class Kind : std::uint8_t { Datagram, Direct, Presence, Summary };
  struct Message {
    Kind kind{};
    std::int64_t at = 0;  ///< ns
    std::vector<std::byte> bytes;
    net::Address from{};  ///< of Direct
  };

  void put(Kind kind, std::span<const std::byte> bytes, std::int64_t at,
           const net::Address& from = {}) {
    if (bytes.size() > kMaxBytes) return;
    const std::scoped_lock lock(mutex_);
    while (messages_.size() >= kMaxMessages || bytes_ + bytes.size() > kMaxBytes) {
      bytes_ -= messages_.front().bytes.size();
      messages_.pop_front();
      ++dropped_;
    }
    bytes_ += bytes.size();
    messages_.push_back({kind, at, {bytes.begin(), bytes.end()}, from});
  }
  std::deque<Message> take() {
    const std::scoped_lock lock(mutex_);
    bytes_ = 0;
    return std::exchange(messages_, {});
  }
  std::uint64_t dropped() const {
    const std::scoped_lock lock(mutex_);
    return dropped_;
  }

 private:
  mutable std::mutex mutex_;
  std::deque<Message> messages_;
  std::size_t bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace tandem::nats
