// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>

namespace tandem::room {

/// Lines of standard input, without waiting for them. A thread reads, as not every system can tell
/// whether a pipe has something; it may wait there still when the program ends.
class LineInput {
 public:
  LineInput();

  /// The next line, or an empty one where none is there yet. False at the end.
  bool take(std::string& line);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace tandem::room
