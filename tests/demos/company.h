// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "late_member.h"
#include "runner/virtual_session.h"
#include "session/options.h"
#include "session/track.h"

namespace tandem::demos::late_member_test {

/// Honest peers of a demo, in virtual time.
struct Company {
  std::string scene = "cubes";
  int honest = 3;
  int profile = 3;
  double seconds = 6.0;  ///< s
  std::uint64_t seed = 1;
  int together = 0;  ///< only the first so many are compared; 0 = all
  /// Changes the session before it begins, as the links of who is far.
  std::function<void(VirtualSession&)> prepare = {};
};

/// What they have, from LateMember::kSpeaks on.
struct Outcome {
  double p50 = 0.0;     ///< m, between two copies of what moves and nobody owns: of all pairs the
  double p95 = 0.0;     ///< largest
  double rest95 = 0.0;  ///< m, the same of what rests
  std::vector<std::uint64_t> worlds;  ///< hashes at the end
  std::vector<consensus::ReplayStats> replays;
  std::vector<std::uint64_t> late;     ///< what they report of the late member
  std::vector<std::uint64_t> without;  ///< likewise
  std::uint64_t body_steps = 0;        ///< steps of bodies that are awake, replayed ones as well
  int steps = 0;                       ///< of each
  std::vector<PeerRecord> records;
};

/// @param saying  null: nobody is beside them
Outcome run(const Company& company, const Saying* saying);

}  // namespace tandem::demos::late_member_test
