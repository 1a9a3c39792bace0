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

/// A fixed team of threads for the stages of one step; the calling thread is worker 0. Whoever of
/// the others is awake helps: a worker that the machine has put aside takes no work, and nobody
/// waits for it. Only what was begun is waited for. Results must not depend on which worker does
/// what: each piece of work writes only what belongs to itself.
///
/// A worker that waits looks again and again, after 20 us it lets others have its processor, and
/// after 1 ms it is put to sleep. On a busy machine, where a worker was put aside in the middle of
/// its work, the calling thread works alone for some time: it loses a tenth of its time to waiting
/// at most.
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

  /// Call f(begin, end, worker) on consecutive chunks that cover [0, size), each of at most `grain`
  /// indices, the first one from 0, the next from `grain` and so on. Each worker begins with its
  /// own part of them, the same one for the same size: its caches have what it had in hand before.
  /// Then it helps the others. Fewer than eight chunks are left to the calling thread, in one call
  /// with all of them: what they are about is in its caches. Allocates nothing. f must not throw.
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

  /// Whether f(begin, end) of some chunk is true. Once one is, others may not be asked.
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

  /// Call f(task, worker) for the tasks from 0 to count - 1, begun in this order.
  template <class F>
  void for_tasks(std::uint32_t count, F&& f) {
    if (count_ == 1 || count <= 1) {
      for (std::uint32_t task = 0; task < count; ++task) f(task, 0);
      return;
    }
    auto visit = [&](std::uint32_t task, int worker) { f(task, worker); };
    run_tasks(count, detail::visit<decltype(visit)>, &visit);
  }

  /// Call f(worker) by each worker that comes while the calling one is at it: f has to do all of
  /// the work, however few come.
  template <class F>
  void for_each(F&& f) {
    auto task = [&](int worker) { f(worker); };
    meet(detail::act<decltype(task)>, &task, true);
  }

  /// The calling thread has waited for so long at a time. @pre several workers
  void note_lost(std::chrono::steady_clock::duration waited);

 private:
  static constexpr std::size_t kFew = 8;  ///< chunks

  using Task = void (*)(void* context, int worker);
  using Visit = void (*)(void* context, std::uint32_t index, int worker);

  void run_chunks(std::uint32_t chunks, Visit visit, void* context);
  void run_tasks(std::uint32_t tasks, Visit visit, void* context);
  /// @param short_parts  a long wait for others says that the machine has put one aside
  void meet(Task task, void* context, bool short_parts);

  struct Team;
  int count_ = 1;
  std::unique_ptr<Team> team_;
};

}  // namespace tandem::pbd
