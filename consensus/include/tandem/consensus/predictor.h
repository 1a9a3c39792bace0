// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/pose_target.h"

namespace tandem::consensus {

/// One body of this peer after one step, with all that agreement has done to it so far.
struct MotionSample {
  SessionTime time = 0;  ///< ns
  double elapsed = 0.0;  ///< s, the same since the history began: products with it stay exact
  pbd::Pose pose;
  pbd::Twist twist;
  pbd::Vec3 displaced = pbd::Vec3::Zero();  ///< m, sum of the displacement channel
  pbd::Vec3 turned = pbd::Vec3::Zero();     ///< rad, sum of its rotation vectors
  pbd::Twist agreed;                        ///< sum of velocity agreement
  pbd::Twist agreed_moment;                 ///< sum of velocity agreement times its `elapsed`
  bool coupled = false;                     ///< touched, joined or held
};

/// The last second or so of one body, as a ring. No allocation.
class MotionHistory {
 public:
  static constexpr std::size_t kCapacity = 128;

  /// `sample.time` must grow; `displaced`, `turned`, `agreed` and `agreed_moment` are summed here.
  void push(SessionTime time, const pbd::Pose& pose, const pbd::Twist& twist,
            const pbd::Correction& correction, bool coupled);
  void clear() { count_ = 0; }
  bool empty() const { return count_ == 0; }
  const MotionSample& newest() const { return at(0); }
  /// The state at `time`, interpolated between samples, clamped to the ends of the history.
  MotionSample at_time(SessionTime time) const;
  /// Whether the body was coupled at any time since `time`.
  bool coupled_since(SessionTime time) const;
  /// Whether the body was hit (its velocity jumped) in the step that `time` lies in, or in one next
  /// to it. The peers' steps resolve a hit a little sooner or later, and within the step nobody
  /// knows: velocities around it cannot be compared.
  bool hit_near(SessionTime time) const;

 private:
  const MotionSample& at(std::size_t age) const {
    return samples_[(head_ + kCapacity - 1 - age) % kCapacity];
  }
  std::array<MotionSample, kCapacity> samples_;
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  SessionTime origin_ = 0;
  MotionSample sum_;
};

/// A remote state carried to now, as what the local body misses of it.
struct Prediction {
  pbd::Vec3 translation = pbd::Vec3::Zero();  ///< m, target minus own position
  pbd::Vec3 rotation = pbd::Vec3::Zero();     ///< rad, own to target orientation, world
  pbd::Twist twist;                           ///< target minus own twist
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
};

/// What a predictor may know besides the update and the own history.
struct PredictionContext {
  SessionTime now = 0;
  /// Share that the sender gives to my states over the share that I give to its.
  double mirrored_share = 1.0;
  int peers = 1;  ///< remote peers that share the body
};

/// Carries a remote state to now. Stateless; one object serves all bodies.
class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual Prediction predict(const StateUpdate& update, const MotionHistory& own,
                             const PredictionContext& context) const = 0;
  /// c of the gain rule, see effective_share(): what the predictor bears.
  virtual double gain() const = 0;
};

/// First-order Euler extrapolation, [friston] Eq. 3; orientations are carried by the angular
/// velocity as well, which the paper's prototype left out.
std::unique_ptr<Predictor> make_euler_predictor();

/// Own motion since the stamp, corrections left out, carries the remote state of bodies in contact,
/// jointed or held; free ones add the difference of velocities; owner-driven ones are linear.
std::unique_ptr<Predictor> make_local_motion_predictor();

}  // namespace tandem::consensus
