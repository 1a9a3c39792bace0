// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "frame_queue.h"

namespace tandem::net {

/// Frames for one peer: waiting, and Reliable ones until they are acknowledged, over any number of
/// connections to the same process.
class OutgoingFrames {
 public:
  /// Makes room for `bytes` more by dropping the oldest states; their number is added to `dropped`.
  /// False if that is not enough.
  bool make_room(std::size_t bytes, std::size_t limit, std::uint64_t& dropped) {
    // Frames written and not acknowledged count too.
    const std::size_t needed = queue_cost(bytes) + unacked_.cost();
    const std::size_t room = limit - std::min(needed, limit);
    dropped += waiting_.shed_states(room);
    return waiting_.cost() <= room && needed <= limit;
  }
  void push(consensus::Delivery delivery, std::span<const std::byte> bytes) {
    waiting_.push({.delivery = delivery,
                   .sequence = delivery == consensus::Delivery::Reliable ? ++last_sequence_ : 0,
                   .bytes = {bytes.begin(), bytes.end()}});
  }

  bool empty() const { return waiting_.empty(); }
  /// Writes the next frame: `write(frame)` returns whether it did; otherwise the frame is dropped.
  template <class Write>
  void write_next(Write&& write) {
    QueuedFrame frame = waiting_.pop();
    if (!write(std::as_const(frame)) || frame.delivery != consensus::Delivery::Reliable) return;
    last_written_ = std::max(last_written_, frame.sequence);
    unacked_.push(std::move(frame));
  }

  bool has_written(std::uint64_t sequence) const { return sequence <= last_written_; }
  /// The peer has received all up to this number.
  void acknowledge(std::uint64_t sequence) {
    while (!unacked_.empty() && unacked_.front().sequence <= sequence) unacked_.pop();
  }
  /// A new connection to the same process, which has all up to this number: the rest is sent again.
  void go_on_after(std::uint64_t sequence) {
    acknowledge(sequence);
    while (!unacked_.empty()) waiting_.push_front(unacked_.pop_back());
  }
  /// States are stale by the time the peer is back; Reliable messages are kept for it.
  void drop_states() { waiting_.keep_reliable(); }
  void clear() {
    waiting_.clear();
    unacked_.clear();
  }

 private:
  FrameQueue waiting_;
  FrameQueue unacked_;               // Reliable, written
  std::uint64_t last_sequence_ = 0;  // last number assigned to a Reliable frame
  std::uint64_t last_written_ = 0;
};

}  // namespace tandem::net
