// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/workers.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "tandem/pbd/validate.h"

namespace tandem::pbd {
namespace {

using Clock = std::chrono::steady_clock;

/// For so long a thread looks for what it waits for before it sleeps: waking it costs as much.
constexpr std::chrono::microseconds kSpin{50};
/// Who waits longer for a chunk waits for a thread that the machine has put aside.
constexpr std::chrono::microseconds kPutAside{500};
/// The calling thread then works alone for so many times what it has lost.
constexpr int kAlone = 10;
/// Chunks of a job that is worth waking somebody for. Who is awake helps with shorter ones.
constexpr std::uint32_t kWorthWaking = 8;
/// Looks between two readings of the clock.
constexpr int kLooks = 64;

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

struct __attribute__((visibility("hidden"))) Workers::Team {
  /// Where a thread sleeps until what it waits for has come. Waking a thread that does not sleep
  /// costs a look: the system is asked once for each time that one fell asleep.
  class Bed {
   public:
    enum Cause : int { Awake, Idle, Stage };  ///< what for

    /// Look for 50 us, then sleep.
    /// @return how long, in steps of a few microseconds
    template <class Ready>
    Clock::duration wait_until(Cause cause, Ready&& ready) {
      Clock::time_point start{};
      for (int looks = 0;; ++looks) {
        if (ready()) return {};
        relax();
        if (looks % kLooks != 0) continue;
        if (looks == 0) start = Clock::now();
        if (Clock::now() - start > kSpin) break;
      }
      std::unique_lock lock(mutex_);
      for (;;) {
        sleeps_.store(cause);
        if (ready()) break;
        woken_.wait(lock);
      }
      sleeps_.store(Awake);
      return Clock::now() - start;
    }

    /// After what it waits for has been stored.
    void wake(Cause cause) {
      int asleep = cause;
      if (sleeps_.load() != cause || !sleeps_.compare_exchange_strong(asleep, Awake)) return;
      { const std::lock_guard lock(mutex_); }
      woken_.notify_one();
    }

   private:
    std::atomic<int> sleeps_{Awake};
    std::mutex mutex_;
    std::condition_variable woken_;
  };

  explicit Team(int count) : beds(static_cast<std::size_t>(count)) {}

  /// Who may come in, and how many have: bit 7, a job is open; below, helpers that are in; above,
  /// the number of the job.
  static constexpr std::uint32_t kOpen = 1u << 7;
  static constexpr std::uint32_t kIn = kOpen - 1;
  static constexpr std::uint32_t kJob = kOpen << 1;
  alignas(64) std::atomic<std::uint32_t> gate{0};
  /// The stage, and how many of its chunks were taken from its front and from its back: 22, 21 and
  /// 21 bits. Workers that come back to the same stage find their own chunks again, whose data is
  /// in their caches.
  static constexpr std::uint64_t kFront = 1u << 21;
  static constexpr std::uint64_t kStage = kFront << 21;
  alignas(64) std::atomic<std::uint64_t> taken{0};
  alignas(64) std::atomic<std::uint32_t> done{0};  ///< chunks, of all stages

  alignas(64) std::span<const std::uint32_t> starts;
  bool reverse = false;
  Task task = nullptr;
  void* context = nullptr;
  std::atomic<bool> stop{false};
  Clock::time_point alone_until{};
  std::vector<Bed> beds;  ///< by worker
  std::vector<std::thread> threads;

  /// Also where one of them could not be started.
  ~Team() {
    stop.store(true);
    wake_all(Bed::Idle);
    for (std::thread& thread : threads) thread.join();
  }

  void wake_all(Bed::Cause cause) {
    for (Bed& bed : beds) bed.wake(cause);
  }

  void help(int worker) {
    std::uint32_t seen = 0;  // job
    for (;;) {
      beds[static_cast<std::size_t>(worker)].wait_until(
          Bed::Idle, [&] { return gate.load() / kJob != seen || stop.load(); });
      if (stop.load()) return;
      std::uint32_t now = gate.load();
      bool in = false;
      while ((now & kOpen) != 0 && !in) in = gate.compare_exchange_weak(now, now + 1);
      seen = now / kJob;
      if (!in) continue;
      work(worker);
      const std::uint32_t left = gate.fetch_sub(1) - 1;
      if ((left & (kOpen | kIn)) == 0) beds[0].wake(Bed::Stage);
    }
  }

  /// The calling thread has waited.
  void lost(Clock::duration waited) {
    if (waited > kPutAside) alone_until = Clock::now() + kAlone * waited;
  }

  /// Take chunks until all are taken.
  void work(int worker) {
    const auto stages = static_cast<std::uint32_t>(starts.size() - 1);
    const std::uint64_t own = worker % 2 == 0 ? kFront : 1;
    std::uint64_t now = taken.load();
    std::uint32_t finished = 0;  // chunks of the stage, by this worker: told at once
    for (;;) {
      const auto nth = static_cast<std::uint32_t>(now / kStage);
      if (nth == stages) return;
      const std::uint32_t stage = reverse ? stages - 1 - nth : nth;
      const auto front = static_cast<std::uint32_t>(now / kFront % kFront);
      const auto back = static_cast<std::uint32_t>(now % kFront);
      const std::uint32_t first = starts[stage];
      const std::uint32_t end = starts[stage + 1];
      // A stage that is not shared stays with whose caches have the most.
      const bool not_mine = end - first == 1 && worker != 0;
      if (front + back < end - first && !not_mine) {
        if (!taken.compare_exchange_weak(now, now + own)) continue;
        task(context, own == kFront ? first + front : end - 1 - back, worker);
        ++finished;
        now = taken.load();
        continue;
      }
      const std::uint32_t all = reverse ? starts[stages] - first : end;
      if (finished > 0) {
        const bool last = done.fetch_add(finished) + finished == all;
        finished = 0;
        if (last) wake_all(Bed::Stage);
      }
      Bed& bed = beds[static_cast<std::size_t>(worker)];
      const auto waited = bed.wait_until(Bed::Stage, [&] { return done.load() >= all; });
      if (worker == 0) lost(waited);
      const std::uint64_t next = std::uint64_t{nth + 1} * kStage;
      if (taken.compare_exchange_strong(now, next)) now = next;
    }
  }
};

Workers::Workers(int count) : count_(count) {
  if (count < 1 || count > 64) {
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

void Workers::run_stages(std::span<const std::uint32_t> starts, bool reverse, Task task,
                         void* context) {
  const std::uint32_t chunks = starts.back();
  const auto stages = static_cast<std::uint32_t>(starts.size() - 1);
  if (count_ == 1 || chunks == stages || Clock::now() < team_->alone_until) {
    for (std::uint32_t n = 0; n < chunks; ++n) task(context, reverse ? chunks - 1 - n : n, 0);
    return;
  }
  Team& team = *team_;
  team.starts = starts;
  team.reverse = reverse;
  team.task = task;
  team.context = context;
  team.taken.store(0);
  team.done.store(0);
  team.gate.fetch_add(Team::kJob + Team::kOpen);
  if (chunks >= kWorthWaking) team.wake_all(Team::Bed::Idle);
  team.work(0);
  team.gate.fetch_sub(Team::kOpen);
  team.lost(team.beds[0].wait_until(Team::Bed::Stage,
                                    [&] { return (team.gate.load() & Team::kIn) == 0; }));
}

}  // namespace tandem::pbd
