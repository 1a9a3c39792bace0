// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/workers.h"

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "patience.h"
#include "tandem/pbd/validate.h"

namespace tandem::pbd {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxWorkers = 64;
/// Spinning time of a thread before it sleeps. Between two shared stages there are some 0.1 ms of
/// others, and in a virtual machine waking a thread takes as long: with 50 us a heap of 8000 cubes
/// takes 1.2 times longer on eight cores than with 300.
constexpr std::chrono::milliseconds kPatience{1};
/// A longer wait, except at the end of tasks, means that the OS has preempted a worker.
constexpr std::chrono::microseconds kPutAside{500};
/// The calling thread then works alone for this many times the lost time.
constexpr int kAlone = 10;

}  // namespace

struct __attribute__((visibility("hidden"))) Workers::Team {
  /// A parking slot, where a thread sleeps until its condition holds. Waking a thread that does not
  /// sleep costs one read.
  class Bed {
   public:
    /// Spins, then sleeps.
    /// @return the time, in steps of a few microseconds
    template <class Ready>
    Clock::duration wait_until(Ready&& ready) {
      Patience patience;
      while (patience.longest() < kPatience) {
        if (ready()) return patience.longest();
        patience.look();
      }
      const Clock::time_point start = Clock::now();
      std::unique_lock lock(mutex_);
      for (;;) {
        sleeps_.store(true);
        if (ready()) break;
        woken_.wait(lock);
      }
      sleeps_.store(false);
      return patience.longest() + (Clock::now() - start);
    }

    /// Call after the condition was stored.
    void wake() {
      if (!sleeps_.load() || !sleeps_.exchange(false)) return;
      { const std::lock_guard lock(mutex_); }
      woken_.notify_one();
    }

   private:
    std::atomic<bool> sleeps_{false};
    std::mutex mutex_;
    std::condition_variable woken_;
  };

  /// State of a worker that enters and leaves a job, on a cache line of its own.
  struct alignas(64) Seat {
    std::atomic<bool> taken{false};
    Bed bed;
  };
  /// Chunks that are not taken yet.
  struct alignas(64) Range {
    std::atomic<std::uint32_t> next{0};
    std::uint32_t end = 0;
  };

  /// Number of the job, odd while it is open.
  alignas(64) std::atomic<std::uint32_t> job{0};
  // The job; written while it is closed and no worker but the caller is in it.
  Task task = nullptr;
  void* context = nullptr;
  std::atomic<bool> stop{false};
  Clock::time_point alone_until{};
  std::vector<Seat> seats;  ///< by worker
  std::array<Range, kMaxWorkers> ranges;
  std::vector<std::thread> threads;

  explicit Team(int count) : seats(static_cast<std::size_t>(count)) {}

  /// Also used if a thread could not be started.
  ~Team() {
    stop.store(true);
    for (Seat& seat : seats) seat.bed.wake();
    for (std::thread& thread : threads) thread.join();
  }

  /// Each worker wakes two others, so that the calling thread does not wake all.
  void wake_next(int worker) {
    const std::size_t first = 2 * static_cast<std::size_t>(worker) + 1;
    for (std::size_t i = first; i < first + 2 && i < seats.size(); ++i) seats[i].bed.wake();
  }

  void help(int worker) {
    Seat& seat = seats[static_cast<std::size_t>(worker)];
    std::uint32_t seen = 0;
    for (;;) {
      std::uint32_t now = 0;
      seat.bed.wait_until([&] {
        now = job.load();
        return (now != seen && now % 2 != 0) || stop.load();
      });
      if (stop.load()) return;
      seen = now;
      // The caller closes the job first and then checks the seats, sequentially consistent.
      seat.taken.store(true);
      if (job.load() == now) {
        wake_next(worker);
        task(context, worker);
      }
      seat.taken.store(false);
      seats[0].bed.wake();
    }
  }

  bool any_seated() const {
    for (const Seat& seat : seats) {
      if (seat.taken.load()) return true;
    }
    return false;
  }
};

Workers::Workers(int count) : count_(count) {
  if (count < 1 || count > kMaxWorkers) {
    detail::refuse("Workers: count", "from 1 to 64", count);
  }
  if (count == 1) return;
  team_ = std::make_unique<Team>(count);
  team_->threads.reserve(static_cast<std::size_t>(count - 1));
  for (int worker = 1; worker < count; ++worker) {
    team_->threads.emplace_back([team = team_.get(), worker] { team->help(worker); });
  }
}

Workers::~Workers() = default;

void Workers::meet(Task task, void* context, bool short_parts) {
  if (count_ == 1 || Clock::now() < team_->alone_until) {
    task(context, 0);
    return;
  }
  Team& team = *team_;
  team.task = task;
  team.context = context;
  team.job.fetch_add(1);
  team.wake_next(0);
  task(context, 0);
  team.job.fetch_add(1);
  const auto waited = team.seats[0].bed.wait_until([&] { return !team.any_seated(); });
  if (short_parts) note_lost(waited);
}

void Workers::note_lost(Clock::duration waited) {
  if (waited > kPutAside) team_->alone_until = Clock::now() + kAlone * waited;
}

void Workers::run_chunks(std::uint32_t chunks, Visit visit, void* context) {
  Team& team = *team_;
  const std::uint32_t ranges = std::min(chunks, static_cast<std::uint32_t>(count_));
  for (std::uint32_t r = 0; r < ranges; ++r) {
    team.ranges[r].next.store(static_cast<std::uint32_t>(std::uint64_t{chunks} * r / ranges),
                              std::memory_order_relaxed);
    team.ranges[r].end = static_cast<std::uint32_t>(std::uint64_t{chunks} * (r + 1) / ranges);
  }
  auto work = [&](int worker) {
    for (std::uint32_t n = 0; n < ranges; ++n) {
      Team::Range& range = team.ranges[(static_cast<std::uint32_t>(worker) + n) % ranges];
      while (range.next.load(std::memory_order_relaxed) < range.end) {
        const std::uint32_t chunk = range.next.fetch_add(1, std::memory_order_relaxed);
        if (chunk >= range.end) break;
        visit(context, chunk, worker);
      }
    }
  };
  meet(detail::act<decltype(work)>, &work, true);
}

void Workers::run_tasks(std::uint32_t tasks, Visit visit, void* context) {
  std::atomic<std::uint32_t>& next = team_->ranges[0].next;
  next.store(0, std::memory_order_relaxed);
  auto work = [&](int worker) {
    for (;;) {
      const std::uint32_t task = next.fetch_add(1, std::memory_order_relaxed);
      if (task >= tasks) return;
      visit(context, task, worker);
    }
  };
  meet(detail::act<decltype(work)>, &work, false);
}

}  // namespace tandem::pbd
