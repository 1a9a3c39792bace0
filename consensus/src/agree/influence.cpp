// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/influence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tandem/pbd/portable.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

using pbd::detail::require;

double weight_of_share(double share) {
  if (!(share > 0.0)) return 0.0;
  if (share >= 1.0) return std::numeric_limits<double>::infinity();
  return share / (1.0 - share);
}

double share_of_weight(double weight) {
  if (!(weight > 0.0)) return 0.0;
  if (std::isinf(weight)) return 1.0;
  return weight / (1.0 + weight);
}

double share_per_step(double share, double dt) {
  if (!(share > 0.0)) return 0.0;
  if (share >= 1.0) return 1.0;
  // expm1 and log1p are exact to rounding for small shares; 1 - pow(1 - s, n) loses digits.
  return -pbd::portable::expm1(dt / kShareInterval * pbd::portable::log1p(-share));
}

void InfluenceOptions::validate() const {
  pbd::detail::require_in(0.0, 1.0, "InfluenceOptions", "baseline", baseline);
  pbd::detail::require_in(0.0, 1.0, "InfluenceOptions", "held_alone", held_alone);
  pbd::detail::require_in(0.0, 1.0, "InfluenceOptions", "leading", leading);
  require(max_age > 0.0 && max_age <= 1e8, "InfluenceOptions", "max_age", max_age,
          "above 0 and at most 1e8 s");
}

double announced_share(const InfluenceOptions& options, bool held_alone, bool leads) {
  const double share =
      held_alone ? std::max(options.baseline, options.held_alone) : options.baseline;
  // A peer that announces no share does not lead.
  return leads && share > 0.0 ? std::max(share, options.leading) : share;
}

}  // namespace tandem::consensus
