// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <console_bridge/console.h>

#include <string>

namespace tandem::urdf_files {

/// Sends urdfdom's messages to the error message, not to the terminal.
class Listener final : public console_bridge::OutputHandler {
 public:
  Listener() { console_bridge::useOutputHandler(this); }
  ~Listener() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_WARN && said.size() < 2000) said += text + "; ";
  }
  std::string said;
};

}  // namespace tandem::urdf_files
