// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>

namespace tandem::room {

/// Non-blocking lines of standard input, by a thread, as not every system can poll a pipe; it may
/// still be blocked when the program ends.
class LineInput {
 public:
  LineInput();

  /// The next line, or an empty one if there is none yet. False at the end.
  bool take(std::string& line);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace tandem::room
