// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

namespace tandem::demos {

/// A progress bar on standard error, if that is a terminal. It ends with the last run.
class Progress {
 public:
  /// @param runs  number of runs, all of one length
  explicit Progress(bool quiet, int runs = 1);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param part  0 to 1, of this run    @param note  shown after the bar
  void show(double part, const std::string& note);
  /// This run has ended, another one follows.
  void next_run() { ++run_; }

 private:
  bool on_;
  int runs_;
  int run_ = 0;
  int shown_ = -1;  ///< per mille
};

}  // namespace tandem::demos
