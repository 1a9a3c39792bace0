// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

namespace tandem::demos {

/// A bar on standard error, where that is a terminal; nothing elsewhere. It ends with the last run.
class Progress {
 public:
  /// @param runs  how many there are, all of one length
  explicit Progress(bool quiet, int runs = 1);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param part  0 to 1, of this run    @param note  written behind the bar
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
