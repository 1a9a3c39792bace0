// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <iosfwd>
#include <string_view>

#include "tandem/pbd/export.h"
#include "tandem/pbd/report.h"

namespace tandem::pbd {

/// Is told of each stage of a step, once it is over: a hook for profilers, see SolverOptions.
class TANDEM_API StageObserver {
 public:
  using Time = std::chrono::steady_clock::time_point;

  virtual ~StageObserver() = default;
  /// On the thread that steps, within the step: it must neither throw nor touch the world. The
  /// stages in the middle come once for each substep of each group of islands.
  virtual void on_stage(Stage stage, Time begin, Time end) noexcept = 0;
};

/// Writes stages as a trace that ui.perfetto.dev and chrome://tracing open.
/// Source: "Trace Event Format", JSON array of complete events, times in us.
/// @par Thread safety  None: one for each thread that steps.
class TANDEM_API StageTrace final : public StageObserver {
 public:
  /// @param out  outlives this object
  explicit StageTrace(std::ostream& out);
  /// Ends the array.
  ~StageTrace() override;
  StageTrace(const StageTrace&) = delete;
  StageTrace& operator=(const StageTrace&) = delete;

  void on_stage(Stage stage, Time begin, Time end) noexcept override;
  /// A span of the application's own on the same line: a whole step, a frame, what a peer does.
  /// @param name  without quotation marks, backslashes and control characters, which are left out
  void span(std::string_view name, Time begin, Time end);

 private:
  std::ostream& out_;
  Time first_{};  ///< of the first event: time 0 of the trace
  bool empty_ = true;
};

}  // namespace tandem::pbd
