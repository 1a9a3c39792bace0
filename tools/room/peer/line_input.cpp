// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/line_input.h"

#include <unistd.h>

#include <mutex>
#include <thread>

namespace tandem::room {

struct LineInput::Shared {
  std::mutex mutex;
  std::string text;
  bool over = false;

  void read_all() {
    char bytes[512];
    for (;;) {
      const auto got = ::read(0, bytes, sizeof bytes);
      const std::lock_guard lock(mutex);
      if (got <= 0) {
        over = true;
        return;
      }
      text.append(bytes, static_cast<std::size_t>(got));
    }
  }
};

LineInput::LineInput() : shared_(std::make_shared<Shared>()) {
  std::thread([shared = shared_] { shared->read_all(); }).detach();
}

bool LineInput::take(std::string& line) {
  line.clear();
  const std::lock_guard lock(shared_->mutex);
  const std::size_t end = shared_->text.find('\n');
  if (end == std::string::npos) return !shared_->over;
  line = shared_->text.substr(0, end);
  shared_->text.erase(0, end + 1);
  if (line.ends_with('\r')) line.pop_back();
  return true;
}

}  // namespace tandem::room
