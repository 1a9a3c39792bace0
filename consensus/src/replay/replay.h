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

/// The mean of all peers' states at their stamps, brought to the present in a scratch world.
/// docs/method.md Secs. 4 and 5.
class Replay {
 public:
  /// One peer's state of one body at its stamp.
  struct News {
    std::uint32_t slot = 0;
    PeerId peer = 0;
    SessionTime stamp = 0;  ///< ns
    double weight = 0.0;    ///< against the own state's 1; infinity = an owner's
    bool carried = false;   ///< to where the replay begins, so that it need not go back so far
    pbd::BodyState state;
    std::size_t frame = 0;  ///< set: of the own history, nearest to the stamp
  };
  /// A body that moves as it is known to, whatever the replay makes of it.
  struct Prescribed {
    std::uint32_t slot = 0;
    /// By another peer's hand, from here on in a straight line; else as it moved here.
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

  /// What the world itself is stepped by; nothing is replayed before that is known.
  void set_solver(const pbd::SolverOptions& options);

  /// A step has ended and is the history's last frame: keep the world as it is, caches and all.
  void keep();
  /// Forget news; what follows until update() is of the step to come.
  void begin() { news_.clear(), prescribed_.clear(); }
  void add(const News& news) { news_.push_back(news); }
  void prescribe(const Prescribed& body) { prescribed_.push_back(body); }
  /// Replay anew, step the last replay along, or leave both out, as the budget allows.
  /// @return whose news are too old for it: 0 where the step has a target
  PeerId update(ReplayStats& stats);
  /// The old one is of other times.
  void drop() { slots_.clear(); }

  /// What this body misses of where the mean of all peers is now; null where nobody knows.
  const pbd::Correction* find(std::uint32_t slot) const {
    return slot < slots_.size() && slots_[slot].covered ? &slots_[slot].gap : nullptr;
  }
  void set_hook(ReplayHook* hook) { hook_ = hook; }
  /// False once the world could not be copied, and where it is not stepped by a solver of ours.
  bool possible() const { return solver_.has_value() && copies_; }

 private:
  /// What comes of one slot.
  struct Slot {
    double weight = 1.0;  ///< of what was blended so far
    bool covered = false;
    pbd::Correction gap = {};  ///< to the mean: what is still missing
  };

  /// Set the frames at which news are taken in: at one all that a peer said at about one time.
  void bring_together();
  /// Take what is older than the start in there.
  void carry_to_start();
  bool start();
  /// Whether the copy has the body that is in that slot now: who came since it was made, or took
  /// the place of somebody else, is not in it.
  bool is_here(std::uint32_t slot) const;
  void forget_strangers();
  bool step_from(std::size_t frame, ReplayStats& stats);
  /// What was done to bodies before that frame, and since the one before it or, where this update
  /// begins, since ever.
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
  pbd::SolverOptions solved_with_;  ///< the world itself
  pbd::WorldCopy copy_;
  ReplayHook* hook_ = nullptr;
  bool copies_ = true;
  Snapshots snapshots_;
  ReplaySchedule schedule_;
  ReplayTethers tethers_;
  std::size_t start_ = 0;    ///< frame
  PeerId oldest_ = 0;        ///< whose news it is
  std::size_t reached_ = 0;  ///< frame
  std::vector<News> news_;
  std::size_t next_ = 0;  ///< of news_, not blended yet
  std::vector<Prescribed> prescribed_;
  std::vector<Slot> slots_;
  std::vector<PeerEstimate> estimates_;
};

}  // namespace tandem::consensus
