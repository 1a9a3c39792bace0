// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// A fixed team of threads for the stages of one step; the calling thread is worker 0. Work is
/// handed out in *chunks*, which anyone may take: a worker that the machine has put aside takes
/// none, and nobody waits for it. Only a chunk that was begun is waited for. Results must not
/// depend on which worker does what: each chunk writes only what belongs to itself.
///
/// Who waits looks again and again for 50 us and is then put to sleep. On a busy machine, where a
/// worker was put aside in the middle of a chunk, the calling thread works alone for some time: it
/// loses a tenth of its time to waiting at most.
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

  /// Call f(chunk, worker) for the chunks of one stage after the other; those of a stage may run at
  /// once. Allocates nothing. f must not throw.
  /// @param starts  chunks before each stage, ascending from 0, and how many there are in all
  /// @param reverse  begin with the last stage
  template <class F>
  void run(std::span<const std::uint32_t> starts, bool reverse, F&& f) {
    using Function = std::remove_reference_t<F>;
    run_stages(
        starts, reverse,
        [](void* context, std::uint32_t chunk, int worker) {
          (*static_cast<Function*>(context))(chunk, worker);
        },
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
    const std::array<std::uint32_t, 2> starts{
        0, static_cast<std::uint32_t>((size + grain - 1) / grain)};
    run(starts, false, [&](std::uint32_t chunk, int worker) {
      const std::size_t begin = chunk * grain;
      f(begin, std::min(size, begin + grain), worker);
    });
  }

 private:
  using Task = void (*)(void* context, std::uint32_t chunk, int worker);
  void run_stages(std::span<const std::uint32_t> starts, bool reverse, Task task, void* context);

  struct Team;
  int count_ = 1;
  std::unique_ptr<Team> team_;
};

}  // namespace tandem::pbd
