// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "agreement.h"
#include "balance.h"
#include "neighbours.h"
#include "part.h"
#include "part_contacts.h"
#include "ranks.h"
#include "seam.h"
#include "tandem/mpi/cluster.h"

namespace tandem::mpi {

/// Steps are in cluster.cpp, files in cluster_checkpoint.cpp.
class __attribute__((visibility("hidden"))) Cluster::Impl {
 public:
  explicit Impl(const ClusterOptions& options);

  pbd::BodyId add(const pbd::BodyDef& def, std::span<const collision::ColliderDef> colliders);
  void use(const collision::Hull& hull);
  void start();
  const pbd::StepReport& step(double dt);
  std::int64_t agree_on(std::int64_t said);
  Totals totals();
  void save(const std::string& path);
  void load(const std::string& path);

  pbd::World& world() { return world_; }
  const collision::CollisionScene& shapes() const { return shapes_; }
  const Part& part() const { return part_; }
  const Ranks& ranks() const { return ranks_; }
  const StepCost& cost() const { return cost_; }
  const ClusterState& state() {
    state_.exchanged = part_.exchanged();
    return state_;
  }
  std::uint64_t steps() const { return steps_; }

 private:
  void arrange(double dt);
  bool needs_balance();
  void share_out();
  void migrate(const std::vector<std::pair<std::uint32_t, int>>& moves);
  void read_section(const Bytes& bytes);

  ClusterOptions options_;
  pbd::World world_;
  collision::CollisionScene shapes_;
  Ranks ranks_;
  pbd::Solver solver_;
  Part part_;
  Neighbours neighbours_;
  IslandAgreement agreement_;
  Load load_;
  // With several ranks only:
  Seam* seam_ = nullptr;  ///< one of the world's blocks
  std::unique_ptr<PartContacts> contacts_;
  std::unique_ptr<Balance> balance_;
  std::vector<std::uint8_t> arrived_;  ///< by slot: came with the last migration
  std::vector<NamedContact> alone_;    ///< from a checkpoint, with one rank
  bool started_ = false;
  std::uint64_t steps_ = 0;
  std::uint64_t refresh_at_ = 0;  ///< step
  StepCost cost_;
  ClusterState state_;
};

}  // namespace tandem::mpi
