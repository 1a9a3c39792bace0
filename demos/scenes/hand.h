// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::demos {

/// Minimum-jerk progress 10 s^3 - 15 s^4 + 6 s^5 from 0 to 1, constant beyond both ends. Velocity
/// and acceleration are 0 at the ends.
double min_jerk(double s);
/// Largest first and second derivative, 15/8 and 10/sqrt(3).
inline constexpr double kMinJerkPeak = 1.875;
inline constexpr double kMinJerkPeakAcceleration = 5.773502691896258;

/// A hand's path: at rest at each knot, on minimum-jerk curves between them.
class HandPath {
 public:
  /// Starts at rest at `position` (m, world), at `time` (s).
  HandPath(double time, const pbd::Vec3& position);
  /// Stays for `duration` s.
  HandPath& wait(double duration);
  /// Moves by `offset` (m) within `duration` s, > 0.
  HandPath& move_by(const pbd::Vec3& offset, double duration);
  HandPath& move_to(const pbd::Vec3& position, double duration);

  pbd::Vec3 at(double time) const;
  double end_time() const { return knots_.back().time; }

 private:
  struct Knot {
    double time;  ///< s
    pbd::Vec3 position;
  };
  std::vector<Knot> knots_;
};

/// The minimum-jerk path between two states of motion: the fifth-order polynomial that meets both
/// [flash1985]. Before its start it is constant; after its end it continues without acceleration.
class MinJerkMove {
 public:
  struct State {
    pbd::Vec3 position = pbd::Vec3::Zero();      ///< m
    pbd::Vec3 velocity = pbd::Vec3::Zero();      ///< m/s
    pbd::Vec3 acceleration = pbd::Vec3::Zero();  ///< m/s^2
  };
  /// At rest.
  explicit MinJerkMove(const pbd::Vec3& position);
  /// @param start, end  s, end > start
  MinJerkMove(double start, const State& from, double end, const State& to);

  State at(double time) const;
  double start() const { return start_; }
  double end() const { return end_; }

 private:
  double start_ = 0.0;
  double end_ = 0.0;
  State to_;
  std::array<pbd::Vec3, 6> coefficients_;  ///< m / s^k
};

/// Physiological tremor: sines between 8 and 12 Hz on each axis, a pure function of time.
class Tremor {
 public:
  static constexpr double kMinHz = 8.0;
  static constexpr double kMaxHz = 12.0;
  static constexpr std::size_t kSines = 4;  ///< on each axis

  /// @param rms  m, of each coordinate
  Tremor(std::uint64_t seed, double rms);
  /// Offset of the hand (m) at `time` (s); each coordinate is within bound().
  pbd::Vec3 at(double time) const;
  double bound() const { return amplitude_ * static_cast<double>(kSines); }

 private:
  struct Sine {
    double frequency;  ///< rad/s
    double phase;      ///< rad
  };
  double amplitude_;  ///< m, of each sine
  std::array<std::array<Sine, kSines>, 3> sines_;
};

}  // namespace tandem::demos
