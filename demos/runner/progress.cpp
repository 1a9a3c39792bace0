// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "runner/progress.h"

#include <algorithm>
#include <cstdio>

#include "arguments/terminal.h"

namespace tandem::demos {

Progress::Progress(bool quiet, int runs) : on_(!quiet && is_terminal(stderr)), runs_(runs) {}

Progress::~Progress() {
  if (on_ && shown_ >= 0) std::fputs("\r\033[K", stderr);
}

void Progress::show(double part, const std::string& note) {
  if (!on_) return;
  const int now = static_cast<int>(1000.0 * (run_ + std::clamp(part, 0.0, 1.0)) / runs_);
  if (now == shown_) return;
  shown_ = now;
  constexpr int kWidth = 40;
  const int filled = now * kWidth / 1000;
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kWidth - filled), '.');
  std::fprintf(stderr, "\r[%s] %3d %%  %s\033[K", bar.c_str(), now / 10, note.c_str());
  std::fflush(stderr);
}

}  // namespace tandem::demos
