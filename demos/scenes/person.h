// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenes/random.h"
#include "scenes/user.h"

namespace tandem::demos {

/// A scripted user with a head and two hands, which others see as shared bodies: "head/<user>",
/// "hand/<user>/0" (left) and "hand/<user>/1" (right). Hands follow minimum-jerk paths with tremor,
/// and hold by three springs each. A person walks by teleporting.
class Person : public User {
 public:
  /// One action: called before each step until it returns true.
  using Act = std::function<bool(Person&)>;

  Person(std::size_t user, Controls& controls, const UserOptions& options);
  void update(consensus::SessionTime now) override;
  Outcome outcome() const override { return score_; }

  /// Appends an action to the script. It is abandoned after `patience` s.
  void then(Act act, double patience = 10.0) { script_.push_back({std::move(act), patience}); }

  // For actions.
  std::size_t user() const { return user_; }
  double time() const { return controls_.time(); }
  /// s since the present action began.
  double acting() const { return time() - act_start_; }
  Random& random() { return random_; }
  const Scene& scene() const { return controls_.scene(); }
  /// A reaction time old.
  const pbd::BodyState& seen(std::size_t body) const { return sight_.seen(body); }
  /// m, intended position.
  pbd::Vec3 hand(int which) const { return hands_[index(which)].move.at(time()).position; }
  /// Moves a hand there within `duration` s, or longer to keep within the speed limits.
  void reach(int which, const pbd::Vec3& to, double duration);
  /// The same, but arriving at that velocity (m/s).
  void swing(int which, const pbd::Vec3& to, const pbd::Vec3& velocity, double duration);
  bool arrived(int which) const { return time() >= hands_[index(which)].move.end(); }
  /// Holds a body at the hand's position. @param load  kg, carried by this hand
  void grasp(int which, std::size_t body, double load, const pbd::Vec3& spread);
  void let_go(int which) { hands_[index(which)].grip.open(); }
  bool holds(int which) const { return hands_[index(which)].grip.closed(); }
  /// Moves at once with head and hands. @param feet  m, world, on the ground
  void teleport(const pbd::Vec3& feet);
  void add_score(const std::string& name, double value);

 private:
  static constexpr double kMaxStretch = 0.4;  ///< m: released beyond it
  // Peaks of a hand's motion except for throws: 0.2 m take 0.54 s, 0.5 m 0.85 s, 1 m 1.6 s.
  static constexpr double kMaxSpeed = 1.2;         ///< m/s
  static constexpr double kMaxAcceleration = 4.0;  ///< m/s^2
  struct Step {
    Act act;
    double patience;
  };
  struct Hand {
    MinJerkMove move;
    Grip grip;
    Tremor tremor;
    double grasped = 0.0;  ///< s, when the grip closed
    std::size_t avatar = 0;
  };
  static std::size_t index(int which) { return static_cast<std::size_t>(which); }
  void act();
  void follow(Hand& hand);

  std::size_t user_;
  Controls& controls_;
  Sight sight_;
  Random random_;
  std::vector<Hand> hands_;
  std::size_t head_;
  pbd::Pose head_pose_;
  std::vector<Step> script_;
  std::size_t next_ = 0;
  double act_start_ = 0.0;
  Outcome score_;
};

}  // namespace tandem::demos
