// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/workers.h"

#include <thread>
#include <vector>

#include "tandem/pbd/validate.h"

namespace tandem::pbd {
namespace {

/// Looks at a flag before a thread lets others have the core: about 20 microseconds.
constexpr int kSpins = 4000;

}  // namespace

struct __attribute__((visibility("hidden"))) Workers::Team {
  std::atomic<std::uint32_t> round{0};    ///< counts calls of run_all; a change starts the workers
  std::atomic<int> busy{0};               ///< helpers that have not finished this round
  std::atomic<int> arrived{0};            ///< workers at the meeting point
  std::atomic<std::uint32_t> meeting{0};  ///< counts meetings
  std::atomic<bool> stop{false};
  Task task = nullptr;
  void* context = nullptr;
  std::vector<std::thread> threads;

  /// Also where one of them could not be started.
  ~Team() {
    stop.store(true, std::memory_order_relaxed);
    round.fetch_add(1, std::memory_order_release);
    round.notify_all();
    for (std::thread& thread : threads) thread.join();
  }

  template <class Ready>
  static void spin_until(Ready&& ready) {
    for (int spins = 0; !ready(); ++spins) {
      if (spins >= kSpins) std::this_thread::yield();
    }
  }

  void work(int worker) {
    std::uint32_t seen = 0;
    for (;;) {
      for (int spins = 0; round.load(std::memory_order_acquire) == seen; ++spins) {
        if (spins >= kSpins) round.wait(seen, std::memory_order_acquire);
      }
      ++seen;
      if (stop.load(std::memory_order_relaxed)) return;
      task(context, worker);
      busy.fetch_sub(1, std::memory_order_release);
    }
  }
};

Workers::Workers(int count) : count_(count) {
  if (count < 1 || count > 64) {
    detail::refuse("Workers: count", "from 1 to 64", count);
  }
  if (count == 1) return;
  team_ = std::make_unique<Team>();
  team_->threads.reserve(static_cast<std::size_t>(count - 1));
  for (int worker = 1; worker < count; ++worker) {
    team_->threads.emplace_back([team = team_.get(), worker] { team->work(worker); });
  }
}

Workers::~Workers() = default;

void Workers::run_all(Task task, void* context) {
  team_->task = task;
  team_->context = context;
  team_->busy.store(count_ - 1, std::memory_order_relaxed);
  team_->round.fetch_add(1, std::memory_order_release);
  team_->round.notify_all();
  task(context, 0);
  Team::spin_until([&] { return team_->busy.load(std::memory_order_acquire) == 0; });
}

void Workers::meet() {
  if (count_ == 1) return;
  const std::uint32_t meeting = team_->meeting.load(std::memory_order_acquire);
  if (team_->arrived.fetch_add(1, std::memory_order_acq_rel) == count_ - 1) {
    team_->arrived.store(0, std::memory_order_relaxed);
    team_->meeting.fetch_add(1, std::memory_order_release);
    return;
  }
  Team::spin_until([&] { return team_->meeting.load(std::memory_order_acquire) != meeting; });
}

}  // namespace tandem::pbd
