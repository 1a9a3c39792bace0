// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tandem::nats {

/// Jobs that may wait for a server, done on a thread of their own, those of one owner in turn. One
/// that could not be done is tried again a little later, and holds up its owner's alone.
class JobQueue {
 public:
  using Owner = const void*;
  /// False: not done.
  using Job = std::function<bool()>;

  JobQueue() = default;
  ~JobQueue() { stop(); }
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  void add(Owner owner, Job job);
  /// Returns when the job that is being done is over; the others are not done any more.
  void stop();
  /// Of all owners.
  std::size_t waiting() const;

 private:
  using Clock = std::chrono::steady_clock;

  struct Queue {
    Owner owner = nullptr;
    std::deque<Job> jobs;  // not empty
    Clock::time_point due{};
  };

  void run();
  std::vector<Queue>::iterator of(Owner owner);

  mutable std::mutex mutex_;
  std::condition_variable woken_;
  std::vector<Queue> queues_;  // whose turn it is first
  bool stop_ = false;
  std::thread worker_;  // from the first job on
};

}  // namespace tandem::nats
