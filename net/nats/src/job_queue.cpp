// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "job_queue.h"

#include <algorithm>
#include <utility>

namespace tandem::nats {

namespace {

constexpr std::chrono::milliseconds kTryAgain{100};

}  // namespace

void JobQueue::add(Owner owner, Job job) {
  {
    const std::scoped_lock lock(mutex_);
    if (of(owner) == queues_.end()) queues_.push_back({.owner = owner});
    of(owner)->jobs.push_back(std::move(job));
    if (!worker_.joinable()) worker_ = std::thread([this] { run(); });
  }
  woken_.notify_one();
}

void JobQueue::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  woken_.notify_all();
  if (worker_.joinable()) worker_.join();
}

std::size_t JobQueue::waiting() const {
  const std::scoped_lock lock(mutex_);
  std::size_t out = 0;
  for (const Queue& each : queues_) out += each.jobs.size();
  return out;
}

std::vector<JobQueue::Queue>::iterator JobQueue::of(Owner owner) {
  return std::ranges::find(queues_, owner, &Queue::owner);
}

void JobQueue::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    const auto next = std::ranges::min_element(queues_, {}, &Queue::due);
    if (next == queues_.end()) {
      woken_.wait(lock);
      continue;
    }
    if (const auto due = next->due; due > Clock::now()) {
      woken_.wait_until(lock, due);
      continue;
    }
    const Owner owner = next->owner;
    Job job = std::move(next->jobs.front());
    lock.unlock();
    const bool done = job();
    lock.lock();
    const auto queue = of(owner);
    if (done) {
      queue->jobs.pop_front();
    } else {
      queue->jobs.front() = std::move(job);
    }
    // Sorted by time, so that owners take turns.
    queue->due = Clock::now() + (done ? Clock::duration{} : kTryAgain);
    if (queue->jobs.empty()) queues_.erase(queue);
  }
}

}  // namespace tandem::nats
