// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// What remote states do to the bodies here. OnePass is what this library is about; the others are
/// what it is compared with, on the same engine and behind the same prediction and rules of
/// influence. Bodies that have an owner from the start (ShareDef::owner) follow their owner in all
/// of them: like a user's spring they are an input, not a matter of agreement.
enum class Coupling : std::uint8_t {
  OnePass,  ///< remote states are targets in the solver's pass
  TwoStep,  ///< the paper's scheme: average first, [friston] Secs. 4.2 and 4.6, then a plain step
  None,     ///< states are sent and never used: what copies do that only users' springs join
  /// Transactional: a body belongs to one peer, the others put it where its owner has it. It passes
  /// to whoever acts on it last, by a request and a grant, a round trip after the act; what nobody
  /// has asked for is the lowest id's.
  SingleOwner,
  VirtualCoupling,  ///< a spring and a damper to the remote state, [friston] Sec. 2.6
};

/// Of Coupling::VirtualCoupling: force = mass (w^2 e + 2 z w de/dt), w = 2 pi frequency, z =
/// damping_ratio, e the way to the remote state; torque likewise with the inertia. Taken at the end
/// of the step, as implicit Euler does, so that no gain is too high for the step while the remote
/// state does not answer. Two free peers pull at each other: what is between them swings at sqrt(2)
/// w with a damping ratio of sqrt(2) z. The defaults damp that critically, so that half of it is
/// left after 0.38 s, and bear a delay of 150 ms with linear extrapolation, at which 1 Hz swings
/// up; 2 Hz, which agrees far better on short links, does so from about 80 ms.
struct TANDEM_API VirtualCouplingOptions {
  double frequency = 0.5;                     ///< Hz, > 0, at most 100
  double damping_ratio = 0.7071067811865476;  ///< >= 0, at most 100
  double max_acceleration = 100.0;            ///< m/s^2, > 0: the force is cut at mass times this
  double max_angular_acceleration = 1000.0;   ///< rad/s^2, > 0

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

}  // namespace tandem::consensus
