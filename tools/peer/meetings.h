// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "peer/config.h"
#include "peer/log.h"
#include "program/network.h"

namespace tandem::demos {

/// Connections through NATs (tandem::ice): per peer a file that this one writes, and one that it
/// reads. The user transfers the files.
class Meetings {
 public:
  /// @throws std::runtime_error if one is configured and this build has no ICE
  Meetings(const PeerConfig& config, Network& network, Log& log);
  ~Meetings();
  Meetings(const Meetings&) = delete;
  Meetings& operator=(const Meetings&) = delete;

  /// Writes and reads due files; call several times a second.
  void look();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::demos
