// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// A fixed team of threads for the stages of one step; the calling thread is worker 0. Results must
/// not depend on which worker does what: work is handed out in chunks, each of which writes only
/// what belongs to its own indices.
/// @par Thread safety  One thread at a time may call run() or for_chunks(); they do not nest.
class TANDEM_API Workers {
 public:
  /// @param count  1 to 64; 1 starts no thread
  /// @throws std::invalid_argument outside that range
  explicit Workers(int count = 1);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int count() const { return count_; }

  /// Call f(worker) once on each worker; returns when all have. f must not throw.
  template <class F>
  void run(F&& f) {
    if (count_ == 1) {
      f(0);
      return;
    }
    using Function = std::remove_reference_t<F>;
    run_all([](void* context, int worker) { (*static_cast<Function*>(context))(worker); },
            const_cast<void*>(static_cast<const void*>(&f)));
  }

  /// Call f(begin, end, worker) on consecutive chunks that cover [0, size), each of at most `grain`
  /// indices. Allocates nothing.
  template <class F>
  void for_chunks(std::size_t size, std::size_t grain, F&& f) {
    if (count_ == 1 || size <= grain) {
      if (size > 0) f(std::size_t{0}, size, 0);
      return;
    }
    std::atomic<std::size_t> next{0};
    run([&](int worker) {
      for (;;) {
        const std::size_t begin = next.fetch_add(grain, std::memory_order_relaxed);
        if (begin >= size) return;
        f(begin, std::min(size, begin + grain), worker);
      }
    });
  }

  /// Within run(): wait until every worker has come here.
  void meet();

 private:
  using Task = void (*)(void* context, int worker);
  void run_all(Task task, void* context);

  struct Team;
  int count_ = 1;
  std::unique_ptr<Team> team_;
};

}  // namespace tandem::pbd
