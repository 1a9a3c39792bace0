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

/// The last second or so of one body of this peer.
class TANDEM_API MotionHistory {
 public:
  virtual ~MotionHistory() = default;
  /// The body as it is now.
  virtual MotionSample newest() const = 0;
  /// The state at a time (ns), interpolated between steps, clamped to what is known.
  virtual MotionSample at_time(SessionTime time) const = 0;
};

/// What brings others' states to now.
enum class PredictorKind : std::uint8_t {
  None,   ///< the state as it was stamped
  Euler,  ///< carried on by its velocity, [friston] Eq. 3
  /// Nothing is guessed: the mean of all states is taken at their stamps and replayed to now by the
  /// own physics, see ReplayOptions. Where the world has no copy, and of what
  /// a hand moves that its own peer alone knows, Euler; of owners, who answer to nobody, with their
  /// acceleration, [friston] Sec. 3.3.
  Replay,
};

/// What a predictor is limited by.
struct TANDEM_API PredictorOptions {
  /// s: a state is carried on by its velocity no longer than this. A shorter time trades
  /// responsiveness for stability, [friston] Sec. 3.3.
  double max_extrapolation = 1.0;
  /// Of what is carried on: turn the orientation by the angular velocity. [friston]
  /// Sec. 4.2 does not.
  bool extrapolates_orientation = true;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// What a predictor keeps of one peer's states of one body, from update to update.
struct TANDEM_API PredictorMemory {
  SessionTime stamp = 0;  ///< ns, of the last update taken in; 0 = none
  pbd::Vec3 velocity = pbd::Vec3::Zero();
  pbd::Vec3 acceleration = pbd::Vec3::Zero();
  double frequency = 0.0;  ///< Hz, at which the acceleration changes
};

/// A remote state carried to now, as what the local body misses of it: target minus own.
struct TANDEM_API Prediction : pbd::Correction {
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
};

/// What a predictor may know besides the update and the own history.
struct TANDEM_API PredictionContext {
  SessionTime now = 0;
  pbd::Vec3 gravity = pbd::Vec3::Zero();  ///< m/s^2, on this body
  /// Of this body and sender. Null: predictors that remember do without.
  PredictorMemory* memory = nullptr;
};

/// Carries a remote state to now. Stateless but for the context's memory; one object serves all
/// bodies. An application may bring its own, see PeerOptions::own_predictor.
class TANDEM_API Predictor {
 public:
  virtual ~Predictor() = default;
  /// @param own  not empty: the newest sample is of now, and a Prediction is told against it
  /// Called from before_step; must not throw.
  virtual Prediction predict(const StateUpdate& update, const MotionHistory& own,
                             const PredictionContext& context) const = 0;
  /// Whether it uses the context's memory.
  virtual bool remembers() const { return false; }
};

/// Of Replay the predictor of what is not replayed.
/// @throws std::invalid_argument where the options are not valid
TANDEM_API std::unique_ptr<Predictor> make_predictor(PredictorKind kind,
                                                     const PredictorOptions& options = {});

}  // namespace tandem::consensus
