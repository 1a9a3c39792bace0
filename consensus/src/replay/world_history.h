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

/// An own spring as it pulls in one step, and its hand as the others carry it on from there.
struct Pull {
  pbd::Tether::Def def;
  HandFilter::Motion told;
};

/// What a world was at the end of each of the last steps, and what acted on it in the step that
/// followed: all that a replay has to know of the past. Memory is kept from frame to frame.
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
  /// What somebody else did to a body, and is known only since: states of the frames in between
  /// are as they were sent, without it.
  struct Late {
    std::uint32_t slot = 0;
    pbd::Twist twist;             ///< change of the twist that the past lacks
    pbd::Twist now;               ///< and that was made when it was taken: less, if it was followed
    SessionTime done = 0;         ///< ns
    SessionTime followed = 0;     ///< ns: later frames have seen the body follow who had it
    SessionTime taken = 0;        ///< ns, time of the last frame then
    pbd::Correction behind = {};  ///< what its pose had fallen behind by then

    /// `state` of that body at `time` with what it lacks.
    pbd::BodyState added_to(const pbd::BodyState& state, SessionTime time) const;
  };
  struct Frame {
    SessionTime time = 0;                ///< ns
    std::vector<pbd::BodyState> states;  ///< by slot, at `time`, as they were sent
    // What acted in the step from `time` on.
    pbd::Vec3 gravity = pbd::Vec3::Zero();
    std::vector<Force> forces;
    std::vector<State> placed;  ///< kinematic bodies, and what the application put somewhere
    std::vector<Push> pushed;   ///< impulses, and twists that the application set
    std::vector<Pull> pulls;
  };

  /// @param longest  ns: what is older is not asked for
  explicit WorldHistory(SessionTime longest) : longest_(longest) {}

  /// A step has ended at `time`. What was known is forgotten where that is no later than before.
  void add(SessionTime time, const pbd::World& world);
  /// Take in bodies that were added since.
  void notice(const pbd::World& world);
  /// The step to come begins: note what the application does to it.
  void note_inputs(const pbd::World& world);
  std::vector<Pull>& pulls() { return newest_frame().pulls; }
  /// Agreement itself has set this body since the last frame: that is nobody's input.
  void note_agreement(std::uint32_t slot, const pbd::World& world);
  /// The body was put where others have it: what it did before is not to be compared with them.
  void restart(std::uint32_t slot, const pbd::World& world);
  /// What was done to a body before has just been done to it here: nobody's input, but states of
  /// the past are compared with others' as if it had been known. @pre late.done <= late.taken
  void note_late(const Late& late);
  /// The application has just done that by an act. Where the step was begun, and its inputs noted,
  /// it counts as one of them.
  void note_own(std::uint32_t slot, const pbd::BodyState& state, const pbd::Twist& change,
                bool placed);
  /// In the order in which they came.
  const std::vector<Late>& late() const { return late_; }
  void clear() { count_ = 0, late_.clear(), noted_ = false; }

  bool empty() const { return count_ == 0; }
  // Frames have numbers that grow.
  std::size_t first() const { return end_ - count_; }
  std::size_t last() const { return end_ - 1; }
  const Frame& frame(std::size_t number) const { return frames_[number % frames_.size()]; }
  /// The last frame that is not later; first() where all are.
  std::size_t at_or_before(SessionTime time) const;
  /// The frame that is next in time.
  std::size_t nearest(SessionTime time) const;

  /// Where a body was, interpolated between frames by the cubic that has their velocities; clamped
  /// to the time that is known of it.
  pbd::BodyState state_at(std::uint32_t slot, SessionTime time) const;
  /// The same to compare a state of another peer with: where the body was hit between two frames it
  /// is on the side of the hit that moves like that.
  pbd::BodyState state_beside(std::uint32_t slot, SessionTime time, const pbd::Twist& other) const;
  const pbd::BodyState& newest(std::uint32_t slot) const { return frame(last()).states[slot]; }
  /// The same with the twists that were changed since by what came late.
  pbd::BodyState present(std::uint32_t slot) const;
  /// How far the body has fallen behind, since some of what was done to it came late: what was
  /// taken from `first` on and before `end`.
  pbd::Correction lag(std::uint32_t slot, SessionTime first, SessionTime end) const;
  /// ns, since when this body is known.
  SessionTime since(std::uint32_t slot) const;
  /// Whether the application has put the body somewhere in a step that began then or later.
  bool placed_since(std::uint32_t slot, SessionTime time) const;
  bool knows(std::uint32_t slot) const { return count_ > 0 && slot < frame(last()).states.size(); }

 private:
  Frame& newest_frame() { return frames_[(end_ - 1) % frames_.size()]; }
  void grow();
  /// `state` of a body at `time` with what was done before, and taken later.
  pbd::BodyState with_late(std::uint32_t slot, SessionTime time, pbd::BodyState state) const;

  SessionTime longest_;
  std::vector<Frame> frames_;
  std::size_t end_ = 0;
  std::size_t count_ = 0;
  std::vector<SessionTime> since_;          ///< ns, by slot
  std::vector<std::uint32_t> generations_;  ///< by slot
  bool noted_ = false;                      ///< the inputs of the step from the last frame on
  std::vector<State> agreed_;
  std::vector<Late> late_;   ///< by `taken`
  std::vector<Push> acted_;  ///< of late_, since the last frame; one of each slot
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
