// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenes/controls.h"
#include "scenes/hand.h"
#include "scenes/hand_record.h"
#include "scenes/outcome.h"
#include "scenes/scene.h"

namespace tandem::demos {

/// A user who acts on one peer's world and sees nothing else.
class User {
 public:
  virtual ~User() = default;
  /// Looks at the world and acts; call before each step, after Controls::begin. `now`: session
  /// time, ns.
  virtual void update(consensus::SessionTime now) = 0;
  /// The user's own score.
  virtual Outcome outcome() const { return {}; }
  /// Measurements of the user's devices.
  virtual std::vector<Series> series() const { return {}; }
};

struct UserOptions {
  std::uint64_t seed = 1;            ///< of tremor and small timing differences
  consensus::SessionTime epoch = 0;  ///< ns, session time at which the script begins
  double seconds = 20.0;             ///< s, when the session ends
  double reaction = 0.2;             ///< s, from an event to the response
  double tremor = 3e-4;            ///< m, rms of each coordinate: peaks of 1 mm, see Tremor::bound
  std::optional<HandRecord> hand;  ///< replaces the script
};

/// Delayed view of some bodies: their states a reaction time ago.
class Sight {
 public:
  /// The scene must outlive it.
  Sight(const Scene& scene, std::vector<std::size_t> bodies, double reaction)
      : scene_(scene), bodies_(std::move(bodies)), reaction_(reaction) {}
  /// @param time  s, increasing
  void look(double time);
  /// State of body number `k` of those watched. @pre look() has been called
  const pbd::BodyState& seen(std::size_t k) const { return frames_.front().states[k]; }
  /// s, time of the seen states.
  double seen_at() const { return frames_.front().time; }

 private:
  struct Frame {
    double time = 0.0;
    std::vector<pbd::BodyState> states;
  };
  const Scene& scene_;
  std::vector<std::size_t> bodies_;
  double reaction_;
  std::deque<Frame> frames_;  ///< oldest first
};

/// Three equal springs between a hand and a body.
struct GripSpec {
  double stiffness = 100.0;                       ///< N/m, each spring
  double damping = 5.0;                           ///< N s/m, each
  double max_force = 15.0;                        ///< N, each
  pbd::Vec3 spread = pbd::Vec3(0.04, 0.04, 0.0);  ///< m, half axes of the triangle of attachments

  static constexpr double kSag =
      0.01;  ///< m, by how much the load of for_load() hangs below the hand

  /// A loose grip: `load` (kg) sags by kSag, with a damping ratio of 0.7; the force limit is four
  /// times its weight. A negative half axis of `spread` mirrors it.
  static GripSpec for_load(double load, const pbd::Vec3& spread);
};

/// One spring with the total stiffness and strength of a grip for that load (kg).
consensus::GrabDef single_spring(double load);

/// A hand that holds one body by three springs ("loose springs" of [friston] Sec. 5.2). The anchors
/// are fixed in the hand, the attachments in the body; they coincide at first.
class Grip {
 public:
  /// Must outlive the grip.
  explicit Grip(Controls& controls) : controls_(controls) {}

  /// Holds that body around the hand. @pre the grip is open
  void close(std::size_t body, const pbd::Pose& hand, const GripSpec& spec);
  /// Sets the hand's pose at the start of the coming step. @pre the grip is closed
  void move(const pbd::Pose& hand);
  void open();
  bool closed() const { return body_.has_value(); }
  std::optional<std::size_t> body() const { return body_; }
  /// m, mean distance of attachments from their anchors in this world.
  double stretch(const pbd::Pose& hand) const;

 private:
  struct Spring {
    std::uint32_t id = 0;                        ///< of Controls
    pbd::Vec3 anchor_l = pbd::Vec3::Zero();      ///< m, frame of the hand
    pbd::Vec3 attachment_l = pbd::Vec3::Zero();  ///< m, frame of the body
  };
  static constexpr std::size_t kSprings = 3;

  Controls& controls_;
  std::optional<std::size_t> body_;
  std::array<Spring, kSprings> springs_;
};

/// A scripted user's plan for a task, made from the world at its start.
struct HandPlan {
  std::size_t body = 0;  ///< index into Scene::bodies
  GripSpec grip;
  HandPath path;  ///< m, world; times in s since the task's start
};

struct HandTask {
  double start = 0.0;  ///< s since the epoch
  /// Empty result: nothing to do.
  std::function<std::optional<HandPlan>()> plan;
};

/// Performs its tasks in order: grabs, follows the path, lets go. It skips a late task (as after a
/// restart) and releases a body that does not follow its hand.
class ScriptedUser final : public User {
 public:
  static constexpr double kPatience = 0.5;    ///< s: a task that is later is skipped
  static constexpr double kMaxStretch = 0.4;  ///< m: released beyond it

  ScriptedUser(Controls& controls, const UserOptions& options, std::vector<HandTask> tasks);
  void update(consensus::SessionTime now) override;
  Outcome outcome() const override { return {{"tasks_done", done_}}; }

 private:
  void start_task(double time);
  void follow(double time);

  std::vector<HandTask> tasks_;
  Controls& controls_;
  std::size_t next_ = 0;
  double done_ = 0.0;  ///< completed tasks
  double task_start_ = 0.0;
  std::optional<HandPlan> plan_;
  Grip grip_;
  Tremor tremor_;
};

}  // namespace tandem::demos
