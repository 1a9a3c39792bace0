// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// One peer's state of a body, carried to now by a predictor.
struct TANDEM_API PeerEstimate {
  PeerId peer = 0;
  pbd::Pose pose = {};    ///< world
  pbd::Twist twist = {};  ///< world
  double share = 0.0;     ///< share that counts now; 1 or more = owner
  double weight = 0.0;    ///< set by fuse(): relative to the local 1; of owners 1 each
};

/// Fuse any number of remote states of one body into one target, [friston] Eqs. 1 and 2 with the
/// local state at weight 1:
///   w_i = s_i / (1 - s_i),  W = sum w_i,  share = W / (1 + W)
///   position, linear, angular:  sum w_i x_i / W, so that x + share (target - x) is Eq. 1
///   rotation_error:  exp(share * rotation_error) q_local = q*, the dominant eigenvector of
///                    q_local q_local^T + sum w_i q_i q_i^T (Eq. 2)
///   pose.orientation:  the mean over the remote states alone, for display
/// One remote state at angle t turns the local one by atan2(W sin t, 1 + W cos t).
/// If remote states are more than 60 degrees apart, their mean is ambiguous: the orientation is
/// then that of the heaviest state (lowest peer id among equals) with its own weight; positions are
/// still averaged. A distant local state does not matter: the mean is well defined up to half a
/// turn. If Eq. 2 has no unique solution (two equal weights half a turn apart) the local
/// orientation is kept.
/// Owners (share 1) override all others and the local state: the result is their mean, share 1.
///
/// The result does not depend on the order of `estimates`. They are sorted by peer in place, and
/// their weights are set.
/// @pre peers are distinct, numbers finite, orientations unit
/// @param[out] target  all fields but `body` and `motion`; unchanged if the result is false
/// @return false if no estimate has a share above 0
/// Cost O(N^2) dot products for N estimates, no allocation. Errors: none.
TANDEM_API bool fuse(const pbd::Pose& local, std::span<PeerEstimate> estimates,
                     pbd::PoseTarget& target);

}  // namespace tandem::consensus
