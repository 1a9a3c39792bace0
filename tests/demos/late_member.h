// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "runner/virtual_session.h"
#include "tandem/pbd/random.h"

namespace tandem::demos::late_member_test {

/// A member's states of the first peer's bodies, at their age.
struct Saying {
  double age = 0.0;        ///< s
  double other_age = age;  ///< s, of every other update
  bool mixed = false;      ///< each update's age is anywhere between the two
  double influence = 0.08;
  double aside = 0.0;          ///< m, by which it lies
  int every = 1;               ///< steps
  std::size_t bodies = 1'000;  ///< at most
  bool leads = false;
};

/// A member without hands of its own, who says what `Saying` has it from kSpeaks on.
class LateMember {
 public:
  static constexpr consensus::PeerId kId = 99;
  static constexpr double kSpeaks = 2.0;  ///< s: nobody is a newcomer any more

  /// It joins the session's network. The session must outlive it.
  LateMember(VirtualSession& session, const Saying& saying);

  /// After each event of the session.
  void look(consensus::SessionTime now);

 private:
  struct Shot {
    consensus::SessionTime time = 0;
    std::vector<pbd::BodyState> states;
  };
  const Shot& shot_for(consensus::SessionTime now);

  VirtualSession& session_;
  Saying saying_;
  consensus::Transport& line_;
  pbd::SplitMix64 dice_{1};
  std::deque<Shot> past_;
  consensus::SessionTime last_ = 0;
  int steps_ = 0;
  int turns_ = 0;
};

}  // namespace tandem::demos::late_member_test
