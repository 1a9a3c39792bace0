// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "peer/config.h"
#include "peer/log.h"
#include "program/network.h"

namespace tandem::demos {

/// Ways to others through NATs (tandem::ice): for each of them a file that this peer writes, and
/// one that it reads once it is there. Who brings them from one to the other is the user's
/// business.
class Meetings {
 public:
  /// @throws std::runtime_error where the configuration wants one and this build has no ICE
  Meetings(const PeerConfig& config, Network& network, Log& log);
  ~Meetings();
  Meetings(const Meetings&) = delete;
  Meetings& operator=(const Meetings&) = delete;

  /// Writes and reads what is due; some times a second.
  void look();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::demos
