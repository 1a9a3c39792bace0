// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "peer/config.h"
#include "peer/divergence_gauge.h"
#include "peer/log.h"
#include "peer/meetings.h"
#include "program/network.h"
#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// Logs events of a peer's network: members joining and leaving, refusals, changes by the
/// organiser. Events caused by strangers are rate-limited.
class NetworkWatch {
 public:
  NetworkWatch(const PeerConfig& config, Network& network, DivergenceGauge& divergence, Log& log)
      : config_(config),
        network_(network),
        divergence_(divergence),
        log_(log),
        meetings_(config, network, log) {}

  /// Call several times a second.
  void look(const std::vector<consensus::PeerStatus>& peers);

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;
  struct Company {
    bool connected = false;
    std::uint64_t rejected = 0;
    std::uint64_t over_budget = 0;
    SteadyTime next_told;
  };

  void look_at(const consensus::PeerStatus& status, SteadyTime now);
  void tell_trouble(SteadyTime now);
  void tell_refused(SteadyTime now);
  void look_at_group();

  const PeerConfig& config_;
  Network& network_;
  DivergenceGauge& divergence_;
  Log& log_;
  Meetings meetings_;
  std::map<consensus::PeerId, Company> company_;
  std::string trouble_;
  SteadyTime next_trouble_;
  std::map<std::string, std::uint64_t> told_refused_;
  SteadyTime next_refused_;
  std::int64_t told_stepped_ = 0;
  std::filesystem::file_time_type group_written_{};  ///< of the file that was taken
  std::string group_fault_;                          ///< logged last
  std::uint64_t group_ = 0;
};

}  // namespace tandem::demos
