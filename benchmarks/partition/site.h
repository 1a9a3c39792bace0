// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "partition.h"
#include "scenes/scene.h"
#include "tandem/pbd/solver.h"

namespace tandem::partition_bench {

/// A scene of balls and boxes that may be cut into parts.
enum class Which : std::uint8_t {
  Cliff,  ///< balls fall over a cliff of triangles
  Cubes,  ///< a field of stacks, a heavy ball runs into it along x, across the borders
};
demos::Scene build_scene(Which which, int size);

/// One peer of a world in parts, or the only one of a whole world.
class Site final : private PartitionBodies {
 public:
  /// @param cells  empty: the whole world is here, and nothing is shared
  Site(demos::Scene scene, consensus::Transport& transport, const std::vector<PartitionCell>& cells,
       const PartitionOptions& options);

  /// s of processor time that the step took, agreement and sending included.
  double step(consensus::SessionTime from, consensus::SessionTime to);

  bool has(std::size_t body) const { return scene_.world->contains(scene_.bodies[body].body); }
  /// Whether this peer has the last word on a body that is here: it lies in its cell.
  bool decides(std::size_t body) const;
  /// m, world: where the bodies are on which it has the last word.
  std::vector<pbd::Vec3> decided() const;
  void set_cells(std::vector<PartitionCell> cells) { partition_->set_cells(std::move(cells)); }
  const pbd::Pose& pose(std::size_t body) const { return scene_.pose(body); }
  const pbd::Twist& twist(std::size_t body) const { return scene_.twist(body); }
  const demos::Scene& scene() const { return scene_; }
  const consensus::PeerStats& stats() const { return peer_->stats(); }
  PartitionStats members() const;

 private:
  pbd::BodyId appear(const consensus::SharedId& id, const pbd::Pose& pose,
                     const pbd::Twist& twist) override;
  void vanish(const consensus::SharedId& id, pbd::BodyId body) override;

  /// A body as it was, with its shapes.
  struct Plan {
    std::size_t index = 0;
    pbd::BodyDef def;
    std::vector<collision::ColliderDef> colliders;
  };

  demos::Scene scene_;
  std::map<consensus::SharedId, Plan> plans_;
  std::vector<std::vector<collision::ColliderId>> colliders_;  ///< by body of the scene
  consensus::PeerId self_;
  pbd::Solver solver_;
  std::unique_ptr<consensus::Peer> peer_;
  std::unique_ptr<Partition> partition_;
};

}  // namespace tandem::partition_bench
