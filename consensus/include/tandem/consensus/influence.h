// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/export.h"

namespace tandem::consensus {

// Influence, defined once: a *share* s (0 to 1) is the part of the gap to a remote state that is
// closed per 1/60 s of session time, independent of the step length. Against the local weight 1 it
// is the weight w = s / (1 - s) of [friston] Eq. 1. A sender with a share of 1 is the *owner*.

/// s, the interval to which a share applies.
inline constexpr double kShareInterval = 1.0 / 60.0;

/// Weight w = s / (1 - s) relative to the local weight 1; +infinity for s >= 1, 0 for s <= 0.
TANDEM_API double weight_of_share(double share);

/// Share s = w / (1 + w); 1 for w = +infinity, 0 for w <= 0.
TANDEM_API double share_of_weight(double weight);

/// Part of the gap closed by a step of `dt` s: 1 - (1 - s)^(60 dt). Two steps close as much as one
/// of twice the length. 1 for s >= 1 and 0 for s <= 0, for any dt >= 0.
TANDEM_API double share_per_step(double share, double dt);

/// Shares that a peer announces for its bodies, and the age up to which remote states count here.
struct TANDEM_API InfluenceOptions {
  /// Announced for bodies without an owner. [friston] Sec. 6.3 uses 0.05 to 0.10 and finds bodies
  /// sluggish above about 0.2 (Sec. 7.12).
  double baseline = 0.08;
  /// Announced while this peer's user holds a body by a constraint that no other peer simulates,
  /// [friston] Sec. 3.2.
  double held_alone = 0.2;
  /// Announced while this peer leads a body (its user was the last and only one to act on it): the
  /// others follow, and this peer ignores their states until they know of the act.
  double leading = 0.8;
  /// s: older states are ignored.
  double max_age = 1.0;
  /// Whether the share of an extrapolated state is at most 1 / (d + 2), d its age in 1/60 s:
  /// docs/method.md Sec. 7.
  bool limits_guesses = true;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Share that a peer announces for a body without an owner, once its authority has ramped up fully.
/// @param held_alone  its user holds the body by a constraint that no other peer simulates
/// @param leads       its user was the last to act on the body, and the only one
TANDEM_API double announced_share(const InfluenceOptions& options, bool held_alone, bool leads);

}  // namespace tandem::consensus
