// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

namespace detail {

template <class F>
void act(void* f, int worker) {
  (*static_cast<F*>(f))(worker);
}
template <class F>
void visit(void* f, std::uint32_t index, int worker) {
  (*static_cast<F*>(f))(index, worker);
}

}  // namespace detail

/// A fixed team of threads for the stages of one step; the calling thread is worker 0. The other
/// workers help if they are running: a worker that the OS has preempted takes no work and is not
/// waited for, unless it has begun some. Results must not depend on which worker does what: each
/// piece of work writes only its own data.
///
/// An idle worker spins, yields after 20 us and sleeps after 1 ms. If the OS preempts a worker
/// mid-chunk, the calling thread works alone for some time, so that it loses at most a tenth of its
/// time to waiting.
/// @par Thread safety  One thread at a time may call these methods; they do not nest.
class TANDEM_API Workers {
 public:
  /// @param count  1 to 64; 1 starts no thread
  /// @throws std::invalid_argument outside that range
  explicit Workers(int count = 1);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int count() const { return count_; }

  /// Call f(begin, end, worker) on consecutive chunks of `grain` indices (the last may be shorter)
  /// that cover [0, size). Each worker begins with its own part, the same one for the same size,
  /// which its caches may still hold; then it helps the others. Fewer than eight chunks are done by
  /// the calling thread in one call, as its caches hold their data. Allocates nothing. f must not
  /// throw.
  template <class F>
  void for_chunks(std::size_t size, std::size_t grain, F&& f) {
    if (count_ == 1 || size < kFew * grain) {
      if (size > 0) f(std::size_t{0}, size, 0);
      return;
    }
    auto visit = [&](std::uint32_t chunk, int worker) {
      const std::size_t begin = chunk * grain;
      f(begin, std::min(size, begin + grain), worker);
    };
    run_chunks(static_cast<std::uint32_t>((size + grain - 1) / grain),
               detail::visit<decltype(visit)>, &visit);
  }

  /// Whether f(begin, end) is true for some chunk. The others may be skipped then.
  template <class F>
  bool any_chunk(std::size_t size, std::size_t grain, F&& f) {
    if (count_ == 1 || size < kFew * grain) return size > 0 && f(std::size_t{0}, size);
    std::atomic<bool> any{false};
    for_chunks(size, grain, [&](std::size_t begin, std::size_t end, int) {
      if (!any.load(std::memory_order_relaxed) && f(begin, end))
        any.store(true, std::memory_order_relaxed);
    });
    return any.load();
  }

  /// Call f(task, worker) for tasks 0 to count - 1, begun in this order.
  template <class F>
  void for_tasks(std::uint32_t count, F&& f) {
    if (count_ == 1 || count <= 1) {
      for (std::uint32_t task = 0; task < count; ++task) f(task, 0);
      return;
    }
    auto visit = [&](std::uint32_t task, int worker) { f(task, worker); };
    run_tasks(count, detail::visit<decltype(visit)>, &visit);
  }

  /// Call f(worker) on each worker that joins while the calling one is busy: f must do all of the
  /// work, however few join.
  template <class F>
  void for_each(F&& f) {
    auto task = [&](int worker) { f(worker); };
    meet(detail::act<decltype(task)>, &task, true);
  }

  /// The calling thread has waited once for that long. @pre several workers
  void note_lost(std::chrono::steady_clock::duration waited);

 private:
  static constexpr std::size_t kFew = 8;  ///< chunks

  using Task = void (*)(void* context, int worker);
  using Visit = void (*)(void* context, std::uint32_t index, int worker);

  void run_chunks(std::uint32_t chunks, Visit visit, void* context);
  void run_tasks(std::uint32_t tasks, Visit visit, void* context);
  /// @param short_parts  parts are short: a long wait means that a worker was preempted
  void meet(Task task, void* context, bool short_parts);

  struct Team;
  int count_ = 1;
  std::unique_ptr<Team> team_;
};

}  // namespace tandem::pbd
