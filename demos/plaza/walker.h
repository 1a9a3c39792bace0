// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>

#include "plaza/plaza.h"
#include "scenes/random.h"

namespace tandem::demos {

/// The intended state of a person's hand.
struct HandWish {
  enum class Kind : std::uint8_t { Nothing, Look, Hold, LetGo };
  Kind kind = Kind::Nothing;
  pbd::Vec3 hand = pbd::Vec3::Zero();  ///< m, world
};

/// A scripted person on the square: walks, takes something nearby, carries, pushes or throws it,
/// and walks on. It knows no physics: its driver says what there is to take.
class Walker {
 public:
  Walker(const PlazaOptions& options, std::size_t number);

  /// A step of `dt` s.
  HandWish step(double dt);
  /// Answer to HandWish::Look: there is a body at this place.
  void take(const pbd::Vec3& body);
  /// The held body got away.
  void lose();

  const pbd::Vec3& feet() const { return feet_; }
  std::uint64_t taken() const { return taken_; }

 private:
  enum class Act : std::uint8_t { Stroll, Carry, Push, Throw };

  void begin_stroll();
  void walk(double dt);
  pbd::Vec3 hand_at(double time) const;

  PlazaOptions options_;
  Random random_;
  pbd::Vec3 feet_;
  pbd::Vec3 goal_;
  pbd::Vec3 ahead_ = pbd::Vec3::UnitX();
  Act act_ = Act::Stroll;
  double time_ = 0.0;  ///< s, in the present act
  double until_ = 0.0;
  pbd::Vec3 taken_at_ = pbd::Vec3::Zero();
  pbd::Vec3 offset_ = pbd::Vec3::Zero();  ///< of the hand from the feet, at the grasp
  std::uint64_t taken_ = 0;
};

}  // namespace tandem::demos
