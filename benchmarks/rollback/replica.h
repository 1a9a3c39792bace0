// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rollback/wire.h"
#include "scenes/scenario.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world_copy.h"

namespace tandem::rollback_bench {

inline constexpr double kFrameHz = 60.0;
/// ns, of the beginning.
consensus::SessionTime frame_time(std::int64_t frame);
/// s
double frame_duration(std::int64_t frame);

/// A world that is a function of all peers' inputs: the same inputs, the same bits.
/// @par Thread safety  One object: one thread at a time.
class Replica {
 public:
  /// State beside the world on which the next frame depends.
  struct Carried {
    struct Spring {
      std::uint32_t peer = 0, user = 0, number = 0;
      pbd::ConstraintId row;
      pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s, of the hand, smoothed as in consensus::Peer
      pbd::Vec3 anchor = pbd::Vec3::Zero();    ///< m, last stated position of the hand
      std::int64_t moved = 0;                  ///< frame
    };
    struct Driven {
      std::uint32_t peer = 0, user = 0, body = 0;
      std::array<double, 7> values = {};  ///< as in the input
      std::int64_t moved = 0;             ///< frame
    };
    std::vector<Spring> springs;
    std::vector<Driven> driven;
    std::vector<demos::Signal> pending;  ///< not yet due
  };
  /// The beginning of a frame; its memory is reused.
  struct Saved {
    pbd::WorldCopy world;
    Carried carried;
  };

  Replica(const demos::Scenario& scenario, const pbd::SolverOptions& options);

  void save(Saved& out) const;
  void restore(const Saved& saved);
  /// The same for another process. @throws as World::restore
  std::vector<std::byte> snapshot() const;
  void restore(pbd::ByteReader& in);

  /// Predicts a peer's unknown input: all hands that moved in the frame before stop or continue.
  Inputs predict(std::uint32_t peer, std::int64_t frame, bool go_on) const;
  /// Call for all peers, in the same order everywhere.
  void apply(std::uint32_t peer, std::int64_t frame, const Inputs& inputs);
  void step(std::int64_t frame);

  const demos::Scene& scene() const { return scene_; }
  std::uint64_t hash() const { return scene_.world->hash(); }

 private:
  void play(std::uint32_t peer, std::int64_t frame, const demos::Input& input);
  pbd::BodyId body(const demos::Input& input) const { return scene_.bodies.at(input.body).body; }
  Carried::Spring* find(std::uint32_t peer, const demos::Input& input);

  const demos::Scenario& scenario_;
  demos::Scene scene_;
  pbd::Tethers* tethers_;
  pbd::Solver solver_;
  Carried carried_;
};

}  // namespace tandem::rollback_bench
