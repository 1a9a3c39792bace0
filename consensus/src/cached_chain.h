// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "tandem/consensus/policy.h"

namespace tandem::consensus {

/// A chain that remembers its last answers. Rules have no state, so that the same question has the
/// same answer, and of a thousand bodies in one packet nearly all are asked about alike.
class CachedChain {
 public:
  explicit CachedChain(PolicyChain chain) : chain_(std::move(chain)) {}

  double apply(double share, const InfluenceContext& context) {
    for (std::size_t tried = 0; tried < answers_.size(); ++tried) {
      const Answer& answer = answers_[last_];
      if (answer.share == share && answer.context == context) return answer.result;
      last_ = (last_ + 1) % answers_.size();
    }
    last_ = (last_ + answers_.size() - 1) % answers_.size();  // in place of the oldest
    answers_[last_] = {share, context, chain_.apply(share, context)};
    return answers_[last_].result;
  }

 private:
  struct Answer {
    double share = -1.0;  ///< none
    InfluenceContext context;
    double result = 0.0;
  };
  PolicyChain chain_;
  std::array<Answer, 4> answers_;  ///< a few peers' turns
  std::size_t last_ = 0;
};

}  // namespace tandem::consensus
