// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "tandem/consensus/peer.h"
#include "tandem/pbd/world.h"

namespace tandem::demos {

/// Force = mass (w^2 e + 2 z w de/dt), w = 2 pi frequency, z = damping_ratio, e the way to the
/// remote state; torque likewise with the inertia. Taken at the end of the step, as implicit Euler
/// does, so that no gain is too high for the step while the remote state does not answer. Two free
/// peers pull at each other: what is between them swings at sqrt(2) w with a damping ratio of
/// sqrt(2) z. The defaults damp that critically, so that half of it is left after 0.38 s, and bear
/// a delay of 150 ms with linear extrapolation, at which 1 Hz swings up; 2 Hz, which agrees far
/// better on short links, does so from about 80 ms.
struct VirtualCouplingOptions {
  double frequency = 0.5;                     ///< Hz, > 0, at most 100
  double damping_ratio = 0.7071067811865476;  ///< >= 0, at most 100
  double max_acceleration = 100.0;            ///< m/s^2, > 0: the force is cut at mass times this
  double max_angular_acceleration = 1000.0;   ///< rad/s^2, > 0

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// A spring and a damper to the remote state, [friston] Sec. 2.6, in place of targets in the pass:
/// to compare with. It asks the peer for the targets that the solver would have asked it for.
class VirtualCoupling {
 public:
  /// The world asks the peer for nothing any more. World and peer must outlive it.
  VirtualCoupling(pbd::World& world, consensus::Peer& peer,
                  const VirtualCouplingOptions& options = {});

  /// Pull for a step as long as the last one. After Peer::before_step. @param now  ns
  void pull(consensus::SessionTime now);

 private:
  void pull_towards(const pbd::PoseTarget& target, double dt);
  /// Whoever owns the body has it where it says.
  void follow(const pbd::PoseTarget& target);
  bool rests(const pbd::PoseTarget& target, double dt);

  pbd::World& world_;
  consensus::Peer& peer_;
  VirtualCouplingOptions options_;
  consensus::SessionTime last_ = 0;  ///< ns, of the last pull()
  std::vector<pbd::PoseTarget> targets_;
  std::vector<double> still_;  ///< s, by slot, at rest and in agreement
};

}  // namespace tandem::demos
