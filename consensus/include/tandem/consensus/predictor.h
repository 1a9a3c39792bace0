// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

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

/// The last second or so of one body, as a ring. No allocation after construction.
class MotionHistory {
 public:
  static constexpr std::size_t kCapacity = 128;

  /// `sample.time` must grow; `displaced`, `turned`, `agreed` and `agreed_moment` are summed here.
  void push(SessionTime time, const pbd::Pose& pose, const pbd::Twist& twist,
            const pbd::Correction& correction, bool coupled, bool driven = false);
  void clear() { count_ = free_for_ = undriven_for_ = 0; }
  bool empty() const { return count_ == 0; }
  const MotionSample& newest() const { return at(0); }
  /// The state at `time`, interpolated between samples, clamped to the ends of the history.
  MotionSample at_time(SessionTime time) const;
  /// Whether the orientation at `time` is surely within `angle` (rad, below a quarter turn) of `q`;
  /// cheaper than at_time(), and false where that would have to tell.
  bool within(SessionTime time, const pbd::Quat& q, double angle) const;
  /// Ask for the memory of the newest sample and of those around the one `age` samples ago, which
  /// lie far apart: the histories of a thousand bodies fit into no cache.
  void prefetch(std::size_t age) const;
  /// Whether the body was coupled at any time since `time`.
  bool coupled_since(SessionTime time) const;
  /// Whether a user acted on the body at any time since `time`: by a spring or by a body of theirs.
  bool driven_since(SessionTime time) const;
  /// Where the body was hit (its velocity jumped) in the step that `time` lies in, or in one next
  /// to it: the state at `time` as it would be without the step of the hit, on that side of it
  /// whose velocity is nearer to `velocity` (m/s), carried straight. The peers' steps resolve a hit
  /// a little sooner or later, and within the step nobody knows. Else nothing.
  std::optional<MotionSample> beside_hit(SessionTime time, const pbd::Vec3& velocity) const;

 private:
  const MotionSample& at(std::size_t age) const {
    return samples_[(head_ + kCapacity - 1 - age) % kCapacity];
  }
  std::vector<MotionSample> samples_ = std::vector<MotionSample>(kCapacity);
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  std::size_t free_for_ = 0;      ///< samples since the newest one that was coupled
  std::size_t undriven_for_ = 0;  ///< and since the newest one that a user acted on
  SessionTime origin_ = 0;
  MotionSample sum_;
};

enum class PredictorKind : std::uint8_t {
  None,         ///< the state as it was stamped
  Euler,        ///< first order, [friston] Eq. 3
  SecondOrder,  ///< and its acceleration, with a limit of frequency, [friston] Sec. 3.3
  Kalman,       ///< a filter of constant velocity that knows its own variance
  LocalMotion,  ///< this peer's own motion since the stamp, always
  Blend,        ///< own motion where bodies are coupled, differences of velocity where free, linear
                ///< where a hand moves them
  Adaptive,     ///< the mean of several, weighted by how well each did on this body of late
};

/// What a predictor is limited by.
struct PredictorOptions {
  /// s: a state is carried on by its velocity no longer than this. A shorter time trades
  /// responsiveness for stability, [friston] Sec. 3.3.
  double max_extrapolation = 1.0;
  /// Hz, of SecondOrder: accelerations that change faster count nothing, those at half of it fully.
  double max_frequency = 4.0;
  /// Of Euler and SecondOrder: turn the orientation by the angular velocity. [friston]
  /// Sec. 4.2 does not.
  bool extrapolates_orientation = true;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// What a predictor keeps of one peer's states of one body, from update to update.
struct PredictorMemory {
  SessionTime stamp = 0;  ///< ns, of the last update taken in; 0 = none
  pbd::Vec3 position = pbd::Vec3::Zero();
  pbd::Vec3 velocity = pbd::Vec3::Zero();
  pbd::Vec3 acceleration = pbd::Vec3::Zero();
  double frequency = 0.0;  ///< Hz, at which the acceleration changes
  double position_variance = 0.0;
  double covariance = 0.0;
  double velocity_variance = 0.0;
  double noise = 0.0;  ///< m^2/s^3, of the acceleration

  /// Of Adaptive: what its ways said of a time that is checked once a state of that time has come.
  static constexpr std::size_t kWays = 3;
  SessionTime probed = 0;  ///< ns; 0 = nothing
  std::array<pbd::Vec3, kWays> said = {pbd::Vec3::Zero(), pbd::Vec3::Zero(), pbd::Vec3::Zero()};
  std::array<double, kWays> error = {-1.0, -1.0, -1.0};  ///< m^2, mean of late; < 0 = not known
};

/// A remote state carried to now, as what the local body misses of it.
struct Prediction {
  pbd::Vec3 translation = pbd::Vec3::Zero();  ///< m, target minus own position
  pbd::Vec3 rotation = pbd::Vec3::Zero();     ///< rad, own to target orientation, world
  pbd::Twist twist;                           ///< target minus own twist
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
  double variance = 0.0;  ///< m^2, expected square of the error in position; 0 = not known
};

/// What a predictor may know besides the update and the own history.
struct PredictionContext {
  SessionTime now = 0;
  /// Share that the sender gives to my states over the share that I give to its.
  double mirrored_share = 1.0;
  int peers = 1;                          ///< remote peers that share the body
  pbd::Vec3 gravity = pbd::Vec3::Zero();  ///< m/s^2, on this body
  /// Of this body and sender. Null: predictors that remember do without.
  PredictorMemory* memory = nullptr;
};

/// Carries a remote state to now. Stateless but for the context's memory; one object serves all
/// bodies.
class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual Prediction predict(const StateUpdate& update, const MotionHistory& own,
                             const PredictionContext& context) const = 0;
  /// c of the gain rule, see effective_share(): what the predictor bears.
  virtual double gain() const = 0;
  /// The same for one state: less where another way is taken for it.
  virtual double gain_for(const StateUpdate& /*update*/) const { return gain(); }
  /// Whether it uses the context's memory.
  virtual bool remembers() const { return false; }
};

/// @throws std::invalid_argument where the options are not valid
std::unique_ptr<Predictor> make_predictor(PredictorKind kind, const PredictorOptions& options = {});

}  // namespace tandem::consensus
