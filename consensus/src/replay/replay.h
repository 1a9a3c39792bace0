// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "input/springs.h"
#include "replay/replay_start.h"
#include "replay/replay_tethers.h"
#include "replay/world_history.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/consensus/replay.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world_copy.h"

namespace tandem::consensus {

/// Brings the mean of all peers' states at their stamps to the present, in a scratch world.
/// docs/method.md Secs. 4 and 5.
class Replay {
 public:
  /// One peer's state of one body at its stamp.
  struct News {
    std::uint32_t slot = 0;
    PeerId peer = 0;
    SessionTime stamp = 0;  ///< ns
    double weight = 0.0;    ///< relative to the local state's 1; infinity = an owner's
    bool carried = false;   ///< extrapolated to the replay's start
    pbd::BodyState state;
    std::size_t frame = 0;  ///< set: frame of the local history nearest to the stamp
  };
  /// A body whose motion is known and not simulated by the replay.
  struct Prescribed {
    std::uint32_t slot = 0;
    /// Moved by another peer's hand, from here on in a straight line; else as it moved here.
    std::optional<pbd::BodyState> from = {};
    SessionTime stamp = 0;  ///< ns
  };

  Replay(const pbd::World& world, const WorldHistory& history, const Springs& springs,
         const ReplayOptions& options)
      : world_(world),
        history_(history),
        springs_(springs),
        options_(options),
        tethers_(history, springs, options.inputs) {}

  /// The options that the world is stepped with; nothing is replayed before they are known.
  void set_solver(const pbd::SolverOptions& options);

  /// A step has ended and is the history's last frame: take a snapshot, caches included.
  void keep();
  /// Drop the news; calls until update() are for the step to come.
  void begin() { news_.clear(), prescribed_.clear(); }
  void add(const News& news) { news_.push_back(news); }
  void prescribe(const Prescribed& body) { prescribed_.push_back(body); }
  /// Replay anew, continue the last replay, or skip both, as the budget allows.
  /// @return 0 if the step has a target; else the peer whose news are too old
  PeerId update(ReplayStats& stats);
  /// Discard the last replay: it belongs to other times.
  void drop() { slots_.clear(); }

  /// The correction of this body to the present mean of all peers; null if unknown.
  const pbd::Correction* find(std::uint32_t slot) const {
    return slot < slots_.size() && slots_[slot].covered ? &slots_[slot].gap : nullptr;
  }
  void set_hook(ReplayHook* hook) { hook_ = hook; }
  /// False once the world could not be copied, or if our solver does not step it.
  bool possible() const { return solver_.has_value() && copies_; }

 private:
  /// Result for one slot.
  struct Slot {
    double weight = 1.0;  ///< of all blended so far
    bool covered = false;
    pbd::Correction gap = {};  ///< correction to the mean
  };

  /// Set the frames at which news are blended: one for all states of a peer of about one time.
  void bring_together();
  /// Move news older than the start to the start.
  void carry_to_start();
  bool start();
  /// Whether the copy has the body that is in that slot now. A body added later, or in place of
  /// another, is not in it.
  bool is_here(std::uint32_t slot) const;
  void forget_strangers();
  bool step_from(std::size_t frame, ReplayStats& stats);
  /// Apply acts of the time before that frame, and after the frame before it; all earlier ones too
  /// if this update begins.
  void take_late(std::size_t frame, bool begins);
  void push(const WorldHistory::Late& late, SessionTime time);
  void blend(std::size_t frame);
  void apply_inputs(std::size_t frame);
  std::size_t awake() const;

  const pbd::World& world_;
  const WorldHistory& history_;
  const Springs& springs_;
  ReplayOptions options_;
  std::optional<pbd::Solver> solver_;
  pbd::SolverOptions solved_with_;  ///< of the world's own steps
  pbd::WorldCopy copy_;
  ReplayHook* hook_ = nullptr;
  bool copies_ = true;
  Snapshots snapshots_;
  ReplaySchedule schedule_;
  ReplayTethers tethers_;
  std::size_t start_ = 0;    ///< frame
  PeerId oldest_ = 0;        ///< the peer whose news it is
  std::size_t reached_ = 0;  ///< frame
  std::vector<News> news_;
  std::size_t next_ = 0;  ///< of news_, the first not blended yet
  std::vector<Prescribed> prescribed_;
  std::vector<Slot> slots_;
  std::vector<PeerEstimate> estimates_;
};

}  // namespace tandem::consensus
