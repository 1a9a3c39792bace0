// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/pose_target.h"

namespace tandem::consensus {

/// One body of this peer after one step, with all that agreement has done to it so far.
struct alignas(64) TANDEM_API MotionSample {
  SessionTime time = 0;  ///< ns
  pbd::Pose pose;
  pbd::Twist twist;
  pbd::Vec3 displaced = pbd::Vec3::Zero();  ///< m, sum of the displacement channel
  pbd::Vec3 turned = pbd::Vec3::Zero();     ///< rad, sum of its rotation vectors
  pbd::Twist agreed;                        ///< sum of velocity agreement
  /// Sum of velocity agreement times the MotionHistory::elapsed() of its step.
  pbd::Twist agreed_moment;
};
static_assert(sizeof(MotionSample) == 256, "a sample should fill its cache lines");

/// The last second or so of one body, as a ring. No allocation after construction.
class TANDEM_API MotionHistory {
 public:
  static constexpr std::size_t kCapacity = 128;

  /// In memory of its own.
  MotionHistory() : own_(kCapacity), samples_(own_.data()) {}
  /// One of `beside` histories that share memory sample by sample: the histories of a thousand
  /// bodies fit into no cache, but what is asked of them lies at nearly the same age in all, and so
  /// side by side here.
  /// @param memory  kCapacity * beside samples, as they were made; must outlive the history. Empty:
  ///   nothing may be asked of it, to be replaced
  MotionHistory(std::span<MotionSample> memory, std::size_t place, std::size_t beside)
      : samples_(memory.empty() ? nullptr : &memory[place]), stride_(beside) {}
  ~MotionHistory() = default;
  MotionHistory(MotionHistory&&) noexcept = default;
  MotionHistory& operator=(MotionHistory&&) noexcept = default;
  MotionHistory(const MotionHistory&) = delete;
  MotionHistory& operator=(const MotionHistory&) = delete;

  /// `time` must grow; `displaced`, `turned`, `agreed` and `agreed_moment` are summed here.
  /// @param coupled  touched, joined or held     @param driven  a user acted on it
  void push(SessionTime time, const pbd::Pose& pose, const pbd::Twist& twist,
            const pbd::Correction& correction, bool coupled, bool driven = false);
  void clear() { count_ = free_for_ = undriven_for_ = 0; }
  bool empty() const { return count_ == 0; }
  bool has_memory() const { return samples_ != nullptr; }
  const MotionSample& newest() const { return at(0); }
  /// Whether the body is coupled by the newest sample.
  bool coupled() const { return count_ > 0 && free_for_ == 0; }
  /// s, since the history began: products with it stay exact.
  double elapsed(SessionTime time) const { return 1e-9 * static_cast<double>(time - origin_); }

  /// Where a time lies among the samples: found once for all that is asked about it, until the next
  /// push() or clear().
  struct Moment {
    SessionTime time = 0;
    std::size_t age = 0;  ///< samples, of the newest one that is not later; else of the oldest
  };
  Moment moment(SessionTime time) const;
  /// Change of the twist over the last step by all but agreement: along the forces on the body.
  pbd::Twist pushed() const;
  /// Whether the history goes back that far.
  bool reaches(const Moment& moment) const {
    return count_ > 0 && at(moment.age).time <= moment.time;
  }

  /// Ask for the memory of the newest sample and of those around the one of this age.
  void prefetch(std::size_t age) const {
    if (count_ == 0) return;
    fetch(0);
    if (age > 1) fetch(age - 1);
    if (age > 0 && age < count_) fetch(age);
  }

  /// The state at a time, interpolated between samples (positions by a cubic where nothing touches
  /// the body, else on the line), clamped to the ends of the history.
  MotionSample at_time(const Moment& moment) const;
  MotionSample at_time(SessionTime time) const { return at_time(moment(time)); }
  /// Whether the orientation at a time is surely nearer to `q` than the angle (below a quarter
  /// turn) that half has this cosine; cheaper than at_time(), and false where that would have to
  /// tell.
  bool within(const Moment& moment, const pbd::Quat& q, double half_cosine) const;
  /// Whether the body was coupled at any time since.
  bool coupled_since(const Moment& moment) const { return count_ > 0 && free_for_ <= moment.age; }
  /// Whether a user acted on the body at any time since: by a spring or by a body of theirs.
  bool driven_since(const Moment& moment) const {
    return undriven_for_ < count_ && undriven_for_ <= moment.age;
  }
  /// Where the body was hit (its velocity jumped) in the step that the time lies in, or in one next
  /// to it: the state at the time as it would be without the step of the hit, on that side of it
  /// whose velocity is nearer to `velocity` (m/s), carried straight. The peers' steps resolve a hit
  /// a little sooner or later, and within the step nobody knows. Else nothing.
  std::optional<MotionSample> beside_hit(const Moment& moment, const pbd::Vec3& velocity) const;

 private:
  std::size_t slot(std::size_t age) const { return (head_ + kCapacity - 1 - age) % kCapacity; }
  const MotionSample& at(std::size_t age) const { return samples_[slot(age) * stride_]; }

  void fetch(std::size_t age) const {
    const char* const bytes = reinterpret_cast<const char*>(&at(age));
    for (std::size_t i = 0; i < sizeof(MotionSample); i += 64) __builtin_prefetch(bytes + i);
  }

  std::vector<MotionSample> own_;
  MotionSample* samples_ = nullptr;
  std::size_t stride_ = 1;
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  std::size_t free_for_ = 0;      ///< samples since the newest one that was coupled
  std::size_t undriven_for_ = 0;  ///< and since the newest one that a user acted on
  SessionTime origin_ = 0;
  SessionTime step_ = 0;            ///< ns, between the two newest samples
  std::bitset<kCapacity> hits_;     ///< by slot: the velocity jumped in the step that led there
  std::bitset<kCapacity> coupled_;  ///< by slot
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
struct TANDEM_API PredictorOptions {
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

/// How the difference between two copies of a body has gone on of late: sums for a least squares
/// fit of what it came to after an age to what it was, and to how fast it grew, at the beginning.
struct TANDEM_API SwingFit {
  /// What was seen, until the states of its time have come.
  struct Probe {
    SessionTime time = 0;                    ///< ns; 0 = none
    pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, of the own copy
    pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s, of the own copy
    pbd::Vec3 apart = pbd::Vec3::Zero();     ///< m, from there to the other one
    pbd::Vec3 drift = pbd::Vec3::Zero();     ///< m, difference of velocities times the age
    double age = 0.0;                        ///< s
  };
  static constexpr std::size_t kProbes = 4;
  std::array<Probe, kProbes> probes;
  // m^2: sums of products of a = apart, d = drift, y = what the difference came to, and v = the age
  // times what the difference of velocities came to.
  double aa = 0.0;
  double ad = 0.0;
  double dd = 0.0;
  double ay = 0.0;
  double dy = 0.0;
  double yy = 0.0;
  double dv = 0.0;
  double vv = 0.0;
};

/// What a predictor keeps of one peer's states of one body, from update to update.
struct TANDEM_API PredictorMemory {
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
  static constexpr std::size_t kWays = 4;
  SessionTime probed = 0;  ///< ns; 0 = nothing
  std::array<pbd::Vec3, kWays> said = {pbd::Vec3::Zero(), pbd::Vec3::Zero(), pbd::Vec3::Zero(),
                                       pbd::Vec3::Zero()};
  std::array<double, kWays> error = {-1.0, -1.0, -1.0,
                                     -1.0};  ///< m^2, mean of late; < 0 = not known
  SwingFit swing;
};

/// A remote state carried to now, as what the local body misses of it.
struct TANDEM_API Prediction {
  pbd::Vec3 translation = pbd::Vec3::Zero();  ///< m, target minus own position
  pbd::Vec3 rotation = pbd::Vec3::Zero();     ///< rad, own to target orientation, world
  pbd::Twist twist;                           ///< target minus own twist
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
  double variance = 0.0;  ///< m^2, expected square of the error in position; 0 = not known
};

/// What a predictor may know besides the update and the own history.
struct TANDEM_API PredictionContext {
  SessionTime now = 0;
  /// Share that the sender gives to my states over the share that I give to its.
  double mirrored_share = 1.0;
  int peers = 1;                          ///< remote peers that share the body
  pbd::Vec3 gravity = pbd::Vec3::Zero();  ///< m/s^2, on this body
  bool held = false;                      ///< a user's spring holds the own body
  bool hangs = false;                     ///< a joint or a spring does, and no user: it may swing
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
  /// c of the gain rule, see effective_share(): what the predictor bears; finite, > 0. 1 for one
  /// that extrapolates.
  virtual double gain() const = 0;
  /// The same for one state: less where another way is taken for it.
  virtual double gain_for(const StateUpdate& /*update*/) const { return gain(); }
  /// Whether it uses the context's memory.
  virtual bool remembers() const { return false; }
};

/// @throws std::invalid_argument where the options are not valid
TANDEM_API std::unique_ptr<Predictor> make_predictor(PredictorKind kind,
                                                     const PredictorOptions& options = {});

}  // namespace tandem::consensus
