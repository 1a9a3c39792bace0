// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::net {

struct QueuedFrame {
  consensus::Delivery delivery{};
  std::uint64_t sequence = 0;  // of Reliable; 0 for Newest
  std::vector<std::byte> bytes;
  consensus::SessionTime received = INT64_MIN;  // system clock, ns
};

/// Cost of a frame in a queue's limit: its payload and approximate overhead.
constexpr std::size_t queue_cost(std::size_t payload_bytes) { return payload_bytes + 64; }

/// Frames in order, with their total cost.
class FrameQueue {
 public:
  bool empty() const { return frames_.empty(); }
  std::size_t cost() const { return cost_; }
  const QueuedFrame& front() const { return frames_.front(); }

  void push(QueuedFrame frame) {
    cost_ += queue_cost(frame.bytes.size());
    frames_.push_back(std::move(frame));
  }

  void push_front(QueuedFrame frame) {
    cost_ += queue_cost(frame.bytes.size());
    frames_.push_front(std::move(frame));
  }

  QueuedFrame pop() {
    QueuedFrame frame = std::move(frames_.front());
    frames_.pop_front();
    cost_ -= queue_cost(frame.bytes.size());
    return frame;
  }

  QueuedFrame pop_back() {
    QueuedFrame frame = std::move(frames_.back());
    frames_.pop_back();
    cost_ -= queue_cost(frame.bytes.size());
    return frame;
  }

  void clear() {
    frames_.clear();
    cost_ = 0;
  }

  void keep_reliable() {
    std::erase_if(frames_, [this](const QueuedFrame& frame) {
      if (frame.delivery == consensus::Delivery::Reliable) return false;
      cost_ -= queue_cost(frame.bytes.size());
      return true;
    });
  }

  /// Drops the oldest states until the cost is at most `limit` or none is left; returns their
  /// number.
  std::uint64_t shed_states(std::size_t limit) {
    std::uint64_t dropped = 0;
    while (cost_ > limit) {
      const auto oldest =
          std::ranges::find(frames_, consensus::Delivery::Newest, &QueuedFrame::delivery);
      if (oldest == frames_.end()) break;
      cost_ -= queue_cost(oldest->bytes.size());
      frames_.erase(oldest);
      ++dropped;
    }
    return dropped;
  }

 private:
  std::deque<QueuedFrame> frames_;
  std::size_t cost_ = 0;
};

}  // namespace tandem::net
