// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <vector>

#include "rollback/replica.h"
#include "rollback/view.h"

namespace tandem::rollback_bench {

/// Frames from when a newcomer asks until its users act: all know of it, and that it does nothing
/// before.
inline constexpr std::int64_t kJoinLead = 60;

struct RollbackOptions {
  int input_delay = 0;                ///< frames from an input until it counts, at all peers alike
  int extrapolation = 0;              ///< frames for which unknown hands go on; 0 = they stay
  double smoothing = 0.0;             ///< s, time constant in which the view follows a correction
  int redundancy = 5;                 ///< newest frames in each packet, where not acknowledged
  int prediction_window = 30;         ///< frames beyond the last confirmed one: there it stalls
  int max_frames_per_tick = 3;        ///< of who is behind
  std::int64_t join = 0;              ///< frame at which the last peer asks to come in; 0 = at once
  std::optional<int> other_substeps;  ///< of the second peer; nullopt = as the others
};

struct RollbackStats {
  std::vector<double> frame_ms;  ///< processor time of each tick, all but users and records
  std::uint64_t steps = 0;       ///< of the solver
  std::uint64_t rollbacks = 0;
  std::uint64_t stalled = 0;       ///< ticks without a frame, though there was one to simulate
  std::size_t snapshot_bytes = 0;  ///< that it came in with
};

/// Prediction with rollback, as published: one deterministic world at each peer; inputs are sent in
/// each frame, together with those before it that may be lost; what is not known yet is predicted;
/// where another input comes than was predicted, the world is set back to that frame and simulated
/// again.
/// @par Thread safety  One object: one thread at a time.
class RollbackPeer {
 public:
  /// @param number  from 0; its id is one more
  RollbackPeer(const demos::Scenario& scenario, const demos::DemoOptions& demo,
               const RollbackOptions& options, std::size_t number, consensus::Transport& transport);

  /// A peer's inputs are known in advance: what is then simulated is what all must come to.
  void set_inputs(std::size_t peer, std::vector<Inputs> inputs);
  /// The clock shows the beginning of that frame.
  void tick(std::int64_t clock);

  const std::vector<Inputs>& own() const { return remotes_[number_].inputs; }
  /// By frame, of its beginning, once all inputs before it are known; 0 = not known.
  const std::vector<std::uint64_t>& hashes() const { return hashes_; }
  const RollbackStats& stats() const { return stats_; }
  demos::PeerRecord& record() { return view_.record(); }

 private:
  /// What is known of a peer, this one included.
  struct Remote {
    bool asks_to_join = false;      ///< and has no answer yet
    std::vector<Inputs> inputs;     ///< by frame, without gaps
    std::vector<Inputs> predicted;  ///< what was simulated in their place, in a ring
    std::size_t acknowledged = 0;   ///< so many frames of ours it has
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
  std::int64_t frame_ = 0;          ///< to be simulated next
  std::int64_t confirmed_ = 0;      ///< so many frames are as they will stay
  std::int64_t wrong_ = INT64_MAX;  ///< the oldest frame that was predicted wrongly
  double cpu_ = 0.0;                ///< s, of this tick
  RollbackStats stats_;
};

}  // namespace tandem::rollback_bench
