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

/// Jobs that may block on a server, done on their own thread, each owner's in order. A failed job
/// is retried a little later, and delays only its owner's.
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
  /// Returns when the running job is over; the others are discarded.
  void stop();
  /// Over all owners.
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
  std::vector<Queue> queues_;  // in the order of their turns
  bool stop_ = false;
  std::thread worker_;  // started by the first job
};

}  // namespace tandem::nats
