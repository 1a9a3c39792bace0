// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <vector>

#include "rollback/replica.h"
#include "rollback/view.h"

namespace tandem::rollback_bench {

/// Frames from a newcomer's request until its users act: by then all know of it.
inline constexpr std::int64_t kJoinLead = 60;

struct RollbackOptions {
  int input_delay = 0;          ///< frames from an input until it takes effect, at all peers
  int extrapolation = 0;        ///< frames for which unknown hands continue; 0 = they stop
  double smoothing = 0.0;       ///< s, time constant in which the view follows a correction
  int redundancy = 5;           ///< newest frames in each packet, unless acknowledged
  int prediction_window = 30;   ///< frames beyond the last confirmed one, above which it stalls
  int max_frames_per_tick = 3;  ///< of a peer that is behind
  std::int64_t join = 0;        ///< frame at which the last peer asks to join; 0 = at once
  std::optional<int> other_substeps;  ///< of the second peer; nullopt = as the others
};

struct RollbackStats {
  std::vector<double> frame_ms;  ///< processor time per tick, without users and records
  std::uint64_t steps = 0;       ///< of the solver
  std::uint64_t rollbacks = 0;
  std::uint64_t stalled = 0;       ///< ticks without a frame although one was due
  std::size_t snapshot_bytes = 0;  ///< on joining
};

/// Prediction with rollback, as published: one deterministic world at each peer. Each frame sends
/// inputs, with earlier ones that may be lost; unknown inputs are predicted. After a wrong
/// prediction the world is rolled back and simulated again.
/// @par Thread safety  One object: one thread at a time.
class RollbackPeer {
 public:
  /// @param number  from 0; its id is one more
  RollbackPeer(const demos::Scenario& scenario, const demos::DemoOptions& demo,
               const RollbackOptions& options, std::size_t number, consensus::Transport& transport);

  /// Sets a peer's inputs in advance: the simulation is then the reference.
  void set_inputs(std::size_t peer, std::vector<Inputs> inputs);
  /// Runs a tick. @param clock  the frame that begins now
  void tick(std::int64_t clock);

  const std::vector<Inputs>& own() const { return remotes_[number_].inputs; }
  /// By frame, of its beginning, once all inputs before it are known; 0 = not known.
  const std::vector<std::uint64_t>& hashes() const { return hashes_; }
  const RollbackStats& stats() const { return stats_; }
  demos::PeerRecord& record() { return view_.record(); }

 private:
  /// State of a peer, this one included.
  struct Remote {
    bool asks_to_join = false;      ///< not answered yet
    std::vector<Inputs> inputs;     ///< by frame, without gaps
    std::vector<Inputs> predicted;  ///< used in their place, in a ring
    std::size_t acknowledged = 0;   ///< number of our frames that it has
  };
  bool is_late(std::size_t peer) const { return options_.join > 0 && peer + 1 == remotes_.size(); }
  void receive();
  void read_inputs(std::uint32_t peer, pbd::ByteReader& in);
  void welcome(std::size_t newcomer);
  void join(pbd::ByteReader& in);
  void post(std::size_t to, std::span<const std::byte> bytes, consensus::Delivery delivery);
  void send(int new_frames);
  void send_to(std::size_t to, std::int64_t round_trip, int new_frames);
  void correct();
  void roll_back();
  void sample_inputs();
  void simulate();
  void confirm();
  std::size_t ring(std::int64_t frame) const {
    return static_cast<std::size_t>(frame) % saved_.size();
  }

  RollbackOptions options_;
  std::size_t number_;
  consensus::Transport& transport_;
  Replica world_;
  View view_;
  std::vector<Remote> remotes_;
  std::vector<Replica::Saved> saved_;  ///< beginnings of frames, in a ring
  std::vector<std::uint64_t> hashes_;
  std::int64_t clock_ = 0;
  bool joined_ = true;
  std::int64_t frame_ = 0;          ///< next to be simulated
  std::int64_t confirmed_ = 0;      ///< number of final frames
  std::int64_t wrong_ = INT64_MAX;  ///< the oldest wrongly predicted frame
  double cpu_ = 0.0;                ///< s, of this tick
  RollbackStats stats_;
};

}  // namespace tandem::rollback_bench
