// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/inputs.h"
#include "scenes/outcome.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/types.h"

namespace tandem::demos {

/// One body at one peer at one time.
struct TrackSample {
  consensus::SessionTime time = 0;         ///< ns
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, of the centre
  pbd::Quat orientation = pbd::Quat::Identity();
  double speed = 0.0;                      ///< m/s, of the centre
  pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s, of the centre
  double correction = 0.0;                 ///< m, moved by agreement in the last step
  bool contact = false;                    ///< had a contact in the last step; local peers only
  int users = 0;                           ///< number of this peer's own users that hold the body
};

/// The path of one body at one peer.
class Track {
 public:
  /// Adds a sample; samples that are not later than the last are ignored.
  void push(const TrackSample& sample);
  bool empty() const { return samples_.empty(); }
  const std::vector<TrackSample>& samples() const { return samples_; }

  /// The state at `time`: position by the cubic that matches both velocities, or by two straight
  /// lines at an impact; speed and velocity linearly, orientation on the sphere, the rest from the
  /// earlier sample. Nothing outside the samples, and between two more than `max_gap` (ns) apart.
  std::optional<TrackSample> at(consensus::SessionTime time,
                                consensus::SessionTime max_gap = INT64_MAX) const;

 private:
  std::vector<TrackSample> samples_;
};

/// A remote state, predicted to the present and applied.
struct PredictionSample {
  consensus::PeerId from = 0;
  std::uint32_t body = 0;                  ///< index into the scene's bodies
  consensus::SessionTime time = 0;         ///< ns, time of the prediction
  double age = 0.0;                        ///< s, since the sender's stamp
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, predicted
};

/// Stretch of one spring at its user's peer.
struct StretchSample {
  consensus::SessionTime time = 0;  ///< ns, the start of a step, when hands have moved
  std::uint32_t body = 0;           ///< index into the scene's bodies
  int users = 0;                    ///< number of this peer's own users that hold the body
  double distance = 0.0;            ///< m, from the held point to the anchor
};

/// Pairs of bodies in contact at one peer at one time.
struct ContactFrame {
  consensus::SessionTime time = 0;  ///< ns
  /// (lower << 32) | higher index into the scene's bodies, ascending, each once; fixed parts are
  /// left out.
  std::vector<std::uint64_t> pairs;
};

/// The observed run of one peer. A peer in another process has tracks only.
struct PeerRecord {
  consensus::PeerId id = 0;
  double step_hz = 0.0;
  bool local = true;          ///< false: known by its updates alone
  std::vector<Track> tracks;  ///< one per body of the scene
  std::vector<PredictionSample> predictions;
  std::vector<StretchSample> stretches;   ///< of its own users' springs, one per spring and step
  std::vector<consensus::PeerId> owners;  ///< of each body; 0 = shared by all; may be empty
  std::vector<ContactFrame> contacts;     ///< at every look
  consensus::SessionTime epoch = 0;       ///< ns, of the inputs
  std::vector<double> step_s;             ///< wall time of each step of the solver
  std::vector<double> penetration_m;      ///< of each overlapping pair in each checked frame
  pbd::ConsensusEnergy energy;            ///< sum of all steps
  consensus::SessionTime first_exchange = INT64_MAX;         ///< ns, of the first update
  double parse_s = 0.0, process_s = 0.0, aggregate_s = 0.0;  ///< CPU time
  double cpu_s = 0.0;      ///< CPU time of all steps: the peer's and the solver's
  double targets_s = 0.0;  ///< wall time of Stage::Agree with the targets
  std::uint64_t updates_received = 0;
  std::uint64_t bodies_aggregated = 0;
  std::uint64_t bodies_placed = 0;
  std::uint64_t bytes_sent = 0;
  double seconds = 0.0;        ///< s, session time simulated with other peers
  std::uint64_t hash = 0;      ///< of the world at the end
  Outcome outcome;             ///< score and users' achievements
  std::vector<Series> series;  ///< of its users' devices
  std::vector<Input> inputs;   ///< of its users, user after user
  std::string fault;           ///< the first violated invariant; empty if none

  /// Keeps the first fault. @param at  s, from the start  @param text  empty = no fault
  void note_fault(double at, const std::string& text);
  /// True if a single peer owns the body at the end.
  bool owned(std::size_t body) const { return body < owners.size() && owners[body] != 0; }
};

}  // namespace tandem::demos
