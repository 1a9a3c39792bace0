// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <iosfwd>
#include <string_view>

#include "tandem/pbd/export.h"
#include "tandem/pbd/report.h"

namespace tandem::pbd {

/// Called after each stage of a step: a hook for profilers, see SolverOptions.
class TANDEM_API StageObserver {
 public:
  using Time = std::chrono::steady_clock::time_point;

  virtual ~StageObserver() = default;
  /// Called within the step, on its thread: it must neither throw nor touch the world. The middle
  /// stages are reported once per substep and group of islands.
  virtual void on_stage(Stage stage, Time begin, Time end) noexcept = 0;
};

/// Writes stages as a trace that ui.perfetto.dev and chrome://tracing can open.
/// Source: "Trace Event Format", JSON array of complete events, times in us.
/// @par Thread safety  None: use one per stepping thread.
class TANDEM_API StageTrace final : public StageObserver {
 public:
  /// @param out  outlives this object
  explicit StageTrace(std::ostream& out);
  /// Closes the array.
  ~StageTrace() override;
  StageTrace(const StageTrace&) = delete;
  StageTrace& operator=(const StageTrace&) = delete;

  void on_stage(Stage stage, Time begin, Time end) noexcept override;
  /// A span of the application on the same line: a whole step, a frame.
  /// @param name  quotation marks, backslashes and control characters are dropped
  void span(std::string_view name, Time begin, Time end);

 private:
  std::ostream& out_;
  Time first_{};  ///< begin of the first event: time 0 of the trace
  bool empty_ = true;
};

}  // namespace tandem::pbd
