// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

namespace tandem::demos {

/// A bar on standard error, where that is a terminal; nothing elsewhere.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param part  0 to 1     @param note  written behind the bar
  void show(double part, const std::string& note);

 private:
  bool on_;
  int shown_ = -1;  ///< per mille
};

}  // namespace tandem::demos
