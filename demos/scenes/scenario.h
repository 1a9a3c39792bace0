// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/controls.h"
#include "scenes/scene.h"
#include "scenes/user.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

/// A world beyond these is broken.
struct Bounds {
  double max_distance = 20.0;  ///< m, of a body from the origin
  double max_speed = 20.0;     ///< m/s
  double lowest = 0.0;         ///< m, of a body's centre
};

/// Watches one peer's world and keeps the score.
class Referee {
 public:
  virtual ~Referee() = default;
  /// Call after each step. @param time  s since the run's beginning
  virtual void watch(const Scene& scene, double time) = 0;
  virtual Outcome outcome(const Scene& scene) const = 0;
};

/// A demo, as runners see it.
class Scenario {
 public:
  virtual ~Scenario() = default;
  const std::string& name() const { return name_; }
  virtual Scene build(const SceneOptions& options) const = 0;

  /// Number of the script's users; user u is at peer u + 1, or at the last peer if there are fewer
  /// peers than users.
  std::size_t user_count() const { return users_; }
  /// The controls must outlive the user.
  /// @throws std::invalid_argument if user >= user_count()
  virtual std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                          const UserOptions& options) const = 0;

  /// Handles a due signal at one peer. @param now  ns, session time; not before signal.time
  virtual void on_signal(Scene& /*scene*/, const Signal& /*signal*/,
                         consensus::SessionTime /*now*/) const {}

  virtual Bounds bounds() const { return {}; }
  /// Bodies that recorded hands may hold, as indices into Scene::bodies; empty: not for recorded
  /// hands.
  virtual std::vector<std::size_t> holdable(const Scene& /*scene*/) const { return {}; }
  /// Scale of the motion of recorded hands along each axis.
  virtual pbd::Vec3 hand_scale() const { return pbd::Vec3::Ones(); }

  /// The invariant that a world violates at this moment; empty if none.
  virtual std::string fault(const Scene& /*scene*/) const { return {}; }
  /// Null: no score.
  virtual std::unique_ptr<Referee> make_referee(const Scene& /*scene*/) const { return nullptr; }
  /// Words for a referee's outcome. Empty: no score.
  virtual Achievement achievement(const Outcome& /*outcome*/) const { return {}; }
  /// The coupling of the comparison run, as --coupling takes it.
  virtual std::string_view baseline() const { return "none"; }

 protected:
  /// Unowned bodies, without those whose names begin with a non-empty `but`.
  static std::vector<std::size_t> unowned(const Scene& scene, std::string_view but = {}) {
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const SceneBody& body = scene.bodies[i];
      if (!body.owner && (but.empty() || !body.name.starts_with(but))) result.push_back(i);
    }
    return result;
  }
  Scenario(std::string name, std::size_t users) : name_(std::move(name)), users_(users) {}
  /// @throws std::invalid_argument if user >= user_count()
  void require_user(std::size_t user) const {
    if (user < users_) return;
    pbd::detail::refuse(name_ + ": user", "below " + std::to_string(users_), std::to_string(user));
  }

 private:
  std::string name_;
  std::size_t users_;
};

}  // namespace tandem::demos
