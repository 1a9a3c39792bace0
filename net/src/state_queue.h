// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "channel_wire.h"
#include "frame_queue.h"

namespace tandem::net {

/// States waiting to be sent. If there are too many, the oldest are dropped. Times in ns.
class StateQueue {
 public:
  /// @param life  older states are dropped
  StateQueue(std::size_t limit_bytes, std::int64_t life) : limit_(limit_bytes), life_(life) {}

  bool empty() const { return states_.empty(); }
  std::size_t size() const { return states_.size(); }
  /// States dropped before they were sent.
  std::uint64_t dropped() const { return dropped_; }

  void push(std::span<const std::byte> state, std::int64_t now) {
    states_.push_back({.bytes = {state.begin(), state.end()}, .at = now});
    cost_ += queue_cost(state.size());
    while (cost_ > limit_) drop_oldest();
  }
  void drop_stale(std::int64_t now) {
    while (!states_.empty() && now - states_.front().at > life_) drop_oldest();
  }
  void drop_longer(std::size_t bytes) {
    dropped_ += std::erase_if(states_, [&](const State& state) {
      if (state.bytes.size() <= bytes) return false;
      cost_ -= queue_cost(state.bytes.size());
      return true;
    });
  }

  /// Whether the next state fits into `room` bytes, or there is none.
  bool fits(std::size_t room) const {
    return states_.empty() || kStateHeader + states_.front().bytes.size() <= room;
  }
  /// Appends the next state to `out`. False if there is none, or `out` would exceed `end`.
  bool write(std::size_t end, std::vector<std::byte>& out) {
    if (states_.empty() || out.size() + kStateHeader + states_.front().bytes.size() > end) {
      return false;
    }
    encode({.kind = ChannelSection::Kind::State, .bytes = states_.front().bytes}, out);
    pop();
    return true;
  }

 private:
  struct State {
    std::vector<std::byte> bytes;
    std::int64_t at = 0;
  };

  void pop() {
    cost_ -= queue_cost(states_.front().bytes.size());
    states_.pop_front();
  }
  void drop_oldest() {
    pop();
    ++dropped_;
  }

  std::size_t limit_;
  std::int64_t life_;
  std::deque<State> states_;
  std::size_t cost_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace tandem::net
