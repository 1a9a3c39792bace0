// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "input/hand_filter.h"
#include "tandem/consensus/predictor.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// An own spring in one step, and its hand as the other peers extrapolate it.
struct Pull {
  pbd::Tether::Def def;
  HandFilter::Motion told;
};

/// The world at the end of each of the last steps, and the inputs of the step that followed: all
/// that a replay needs of the past. Memory is reused from frame to frame.
class WorldHistory {
 public:
  struct Force {
    std::uint32_t slot = 0;
    pbd::Wrench wrench;
  };
  struct State {
    std::uint32_t slot = 0;
    pbd::BodyState state;
  };
  struct Push {
    std::uint32_t slot = 0;
    pbd::Twist twist;  ///< change of the twist
  };
  /// An act of another peer that arrived late: the frames in between are as they were sent, without
  /// it.
  struct Late {
    std::uint32_t slot = 0;
    pbd::Twist twist;             ///< change of the twist that the past lacks
    pbd::Twist now;               ///< change made on arrival: less if it had followed
    SessionTime done = 0;         ///< ns, act
    SessionTime followed = 0;     ///< ns: later frames have followed peers with the act
    SessionTime taken = 0;        ///< ns, time of the last frame on arrival
    pbd::Correction behind = {};  ///< correction of the pose that was missing on arrival

    /// `state` of that body at `time` with the act's effect added.
    pbd::BodyState added_to(const pbd::BodyState& state, SessionTime time) const;
  };
  struct Frame {
    SessionTime time = 0;                ///< ns
    std::vector<pbd::BodyState> states;  ///< by slot, at `time`, as they were sent
    // Inputs of the step from `time` on.
    pbd::Vec3 gravity = pbd::Vec3::Zero();
    std::vector<Force> forces;
    std::vector<State> placed;  ///< kinematic bodies, and bodies set by the application
    std::vector<Push> pushed;   ///< impulses, and twists set by the application
    std::vector<Pull> pulls;
  };

  /// @param longest  ns: older times are not requested
  explicit WorldHistory(SessionTime longest) : longest_(longest) {}

  /// A step has ended at `time`. If that is no later than the last frame, the history is cleared.
  void add(SessionTime time, const pbd::World& world);
  /// Record bodies that were added since.
  void notice(const pbd::World& world);
  /// The step to come begins: record the application's inputs to it.
  void note_inputs(const pbd::World& world);
  std::vector<Pull>& pulls() { return newest_frame().pulls; }
  /// Agreement has set this body since the last frame: that is no input.
  void note_agreement(std::uint32_t slot, const pbd::World& world);
  /// The body was placed where others have it: its earlier motion is not compared with theirs.
  void restart(std::uint32_t slot, const pbd::World& world);
  /// A late act was just done here. It is no input, but past states are compared with the others'
  /// as if it had been known. @pre late.done <= late.taken
  void note_late(const Late& late);
  /// The application has just done an act. If the step has begun, and its inputs were recorded, it
  /// counts as one of them.
  void note_own(std::uint32_t slot, const pbd::BodyState& state, const pbd::Twist& change,
                bool placed);
  /// In order of arrival.
  const std::vector<Late>& late() const { return late_; }
  void clear() { count_ = 0, late_.clear(), noted_ = false; }

  bool empty() const { return count_ == 0; }
  // Frame numbers increase.
  std::size_t first() const { return end_ - count_; }
  std::size_t last() const { return end_ - 1; }
  const Frame& frame(std::size_t number) const { return frames_[number % frames_.size()]; }
  /// The last frame that is not later; first() if all are.
  std::size_t at_or_before(SessionTime time) const;
  /// The frame nearest in time.
  std::size_t nearest(SessionTime time) const;

  /// State of a body, interpolated between frames by the cubic with their velocities; clamped to
  /// the recorded interval.
  pbd::BodyState state_at(std::uint32_t slot, SessionTime time) const;
  /// state_at() for comparison with another peer's state: if the body was hit between two frames,
  /// the side of the hit with the similar velocity is used.
  pbd::BodyState state_beside(std::uint32_t slot, SessionTime time, const pbd::Twist& other) const;
  const pbd::BodyState& newest(std::uint32_t slot) const { return frame(last()).states[slot]; }
  /// newest(), with the changes of twist by late acts.
  pbd::BodyState present(std::uint32_t slot) const;
  /// Correction of the body that late acts would have made by now: acts taken from `first` on and
  /// before `end`.
  pbd::Correction lag(std::uint32_t slot, SessionTime first, SessionTime end) const;
  /// ns, since when this body is recorded.
  SessionTime since(std::uint32_t slot) const;
  /// Whether the application has set the body's pose in a step that began then or later.
  bool placed_since(std::uint32_t slot, SessionTime time) const;
  bool knows(std::uint32_t slot) const { return count_ > 0 && slot < frame(last()).states.size(); }

 private:
  Frame& newest_frame() { return frames_[(end_ - 1) % frames_.size()]; }
  void grow();
  /// `state` of a body at `time` with the acts done before and taken later.
  pbd::BodyState with_late(std::uint32_t slot, SessionTime time, pbd::BodyState state) const;

  SessionTime longest_;
  std::vector<Frame> frames_;
  std::size_t end_ = 0;
  std::size_t count_ = 0;
  std::vector<SessionTime> since_;          ///< ns, by slot
  std::vector<std::uint32_t> generations_;  ///< by slot
  bool noted_ = false;                      ///< inputs from the last frame on are recorded
  std::vector<State> agreed_;
  std::vector<Late> late_;   ///< by `taken`
  std::vector<Push> acted_;  ///< of late_, since the last frame; one per slot
};

/// The own motion of one body, for predictors.
class OwnMotion final : public MotionHistory {
 public:
  OwnMotion(const WorldHistory& history, std::uint32_t slot) : history_(history), slot_(slot) {}
  MotionSample newest() const override;
  MotionSample at_time(SessionTime time) const override;

 private:
  const WorldHistory& history_;
  std::uint32_t slot_;
};

}  // namespace tandem::consensus
