// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/pose_target.h"

namespace tandem::consensus {

/// One body of this peer at one time.
struct TANDEM_API MotionSample {
  SessionTime time = 0;  ///< ns
  pbd::Pose pose = {};
  pbd::Twist twist = {};
};

/// About the last second of motion of one body of this peer.
class TANDEM_API MotionHistory {
 public:
  virtual ~MotionHistory() = default;
  /// The present state of the body.
  virtual MotionSample newest() const = 0;
  /// The state at a time (ns), interpolated between steps and clamped to the recorded interval.
  virtual MotionSample at_time(SessionTime time) const = 0;
};

/// How remote states are brought to the present.
enum class PredictorKind : std::uint8_t {
  None,   ///< the state as stamped
  Euler,  ///< extrapolated by its velocity, [friston] Eq. 3
  /// Not extrapolated: the mean of all states is taken at their stamps and replayed to now by the
  /// local physics, see ReplayOptions. Euler if the world cannot be copied, and for bodies moved by
  /// a hand that only its own peer knows; owners' states, which answer to nobody, with their
  /// acceleration too, [friston] Sec. 3.3.
  Replay,
};

/// Limits of a predictor.
struct TANDEM_API PredictorOptions {
  /// s: longest time for which a state is extrapolated. Shorter trades responsiveness for
  /// stability, [friston] Sec. 3.3.
  double max_extrapolation = 1.0;
  /// Whether extrapolation turns the orientation by the angular velocity. [friston] Sec. 4.2 does
  /// not.
  bool extrapolates_orientation = true;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// A predictor's memory of one peer's states of one body, kept between updates.
struct TANDEM_API PredictorMemory {
  SessionTime stamp = 0;  ///< ns, of the last update used; 0 = none
  pbd::Vec3 velocity = pbd::Vec3::Zero();
  pbd::Vec3 acceleration = pbd::Vec3::Zero();
  double frequency = 0.0;  ///< Hz, at which the acceleration changes
};

/// A remote state carried to now, as a correction of the local body: target minus own.
struct TANDEM_API Prediction : pbd::Correction {
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
};

/// Further input of a predictor, besides the update and the local history.
struct TANDEM_API PredictionContext {
  SessionTime now = 0;
  pbd::Vec3 gravity = pbd::Vec3::Zero();  ///< m/s^2, on this body
  /// Memory for this body and sender. Null: a predictor must do without.
  PredictorMemory* memory = nullptr;
};

/// Carries a remote state to now. Stateless but for the context's memory; one object serves all
/// bodies. An application may supply its own, see PeerOptions::own_predictor.
class TANDEM_API Predictor {
 public:
  virtual ~Predictor() = default;
  /// @param own  not empty: its newest sample is of now, and the Prediction is relative to it
  /// Called from before_step; must not throw.
  virtual Prediction predict(const StateUpdate& update, const MotionHistory& own,
                             const PredictionContext& context) const = 0;
  /// Whether it uses the context's memory.
  virtual bool remembers() const { return false; }
};

/// For Replay, the predictor of states that are not replayed.
/// @throws std::invalid_argument if the options are not valid
TANDEM_API std::unique_ptr<Predictor> make_predictor(PredictorKind kind,
                                                     const PredictorOptions& options = {});

}  // namespace tandem::consensus
