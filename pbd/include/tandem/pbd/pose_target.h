// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

class ByteReader;
class ByteWriter;
class World;
struct SolverOptions;

/// How a target moves while the step runs.
enum class TargetMotion : std::uint8_t {
  /// With its own twist and with every acceleration of the local body (gravity, contact, joints):
  /// right if the remote body is simulated too and feels the same.
  WithBody,
  /// With its own twist alone: right if the remote body is moved by hand.
  Inertial,
};

/// A remote estimate of one body, already fused over all peers: a row of the pass.
/// Free body: x* = x + share (x_target - x), the weighted average of [friston] Eq. 1 with the local
/// weight 1 and the remote weight share / (1 - share).
struct TANDEM_API PoseTarget {
  BodyId body = {};
  Pose pose = {};      ///< world, at the start of the coming step
  Twist twist = {};    ///< world
  double share = 0.0;  ///< of the gap, closed per 1/60 s, 0 to 1; 1 = the remote owns the body
  TargetMotion motion = TargetMotion::WithBody;
  /// Rotation vector (rad, world) from the local orientation to the target's; replaces
  /// `pose.orientation` if `use_rotation_error` is set. A fused rotation, a share
  /// of which is the exact average, may exceed half a turn.
  Vec3 rotation_error = Vec3::Zero();
  bool use_rotation_error = false;
};

/// Effect of agreement on one body in the last step.
struct TANDEM_API Correction {
  Vec3 translation = Vec3::Zero();  ///< m, world: sum over the displacement channel
  Vec3 rotation = Vec3::Zero();     ///< rad, world, rotation vector
  Twist twist = {};                 ///< change by velocity agreement
};

/// Provides the poses that remote peers have for bodies; `consensus` implements this.
class TANDEM_API TargetSource {
 public:
  virtual ~TargetSource() = default;

  /// Append the targets of the coming step; at most one per body.
  /// @param options  options of the solver that makes the step
  virtual void collect(const World& world, double dt, const SolverOptions& options,
                       std::vector<PoseTarget>& out) = 0;
};

}  // namespace tandem::pbd
