// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world.h"

namespace tandem::mpi {

/// MPI for the lifetime of the object; made once in a program, before any Cluster.
class TANDEM_API Environment {
 public:
  /// @throws std::runtime_error if MPI is running already or cannot start
  Environment(int& argc, char**& argv);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

  int rank() const;
  int count() const;  ///< of ranks
  /// Ends all ranks, with a reason on standard error: ranks cannot go on without each other.
  [[noreturn]] static void abort(const std::string& reason);
};

/// Cost of a message, for StepCost::modelled. The defaults are a 25 Gbit/s network with a good
/// software stack.
struct TANDEM_API NetworkModel {
  double latency = 5e-6;     ///< s, from send to receive, of an empty message; >= 0
  double bandwidth = 2.5e9;  ///< B/s, > 0
  double overhead = 5e-7;    ///< s of the processor, per message at either end; >= 0
};

struct TANDEM_API ClusterOptions {
  pbd::Vec3 gravity = pbd::Vec3(0.0, 0.0, -9.81);  ///< m/s^2
  /// For the whole world: ContactOptions::extra_rows is divided among the ranks.
  pbd::SolverOptions solver = {};
  collision::CollisionOptions collision = {};
  /// Steps between examinations of the load, >= 1.
  int balance_every = 8;
  /// The load is redistributed if the busiest rank has more than this many times the mean, or if a
  /// small island lies on several ranks.
  double balance_above = 1.05;
  /// An island above this share of a rank's mean load is cut, 0 to 1.
  double cut_above = 0.25;
  /// Steps for which neighbours of other ranks' bodies are searched ahead, >= 1.
  int refresh_every = 4;
  NetworkModel network = {};
  /// Each rank records its inputs in `record`.RANK; empty: none does.
  std::string record = {};
  /// One of these files: this process replays that rank alone, without MPI. It takes the same steps
  /// to the same bits, under a debugger or on another processor. The program must make the same
  /// calls.
  std::string replay = {};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Cost of the last step on this rank.
struct TANDEM_API StepCost {
  double cpu = 0.0;  ///< s of the calling thread, without waiting and transfers by MPI
  /// s by NetworkModel: processor time of this rank and of those that it waited for, and network
  /// time.
  double modelled = 0.0;
  std::size_t messages = 0;  ///< sent
  std::size_t bytes = 0;     ///< sent
};

/// Distribution of the world over the ranks.
struct TANDEM_API ClusterState {
  std::size_t own = 0;          ///< bodies of this rank
  std::size_t copies = 0;       ///< of other ranks' bodies
  std::size_t seam_rows = 0;    ///< contacts that this rank solves between its bodies and others'
  std::size_t cut_islands = 0;  ///< that continue on other ranks
  double imbalance = 1.0;       ///< load of the busiest rank over the mean, by counted work
  std::uint64_t migrated = 0;   ///< bodies that this rank has sent away so far
  std::uint64_t balanced = 0;   ///< number of redistributions
  std::uint64_t exchanged = 0;  ///< increases when this rank gains or loses a body
};

/// Sums over all bodies of all ranks.
struct TANDEM_API Totals {
  std::size_t bodies = 0;
  std::size_t awake = 0;
  double kinetic_energy = 0.0;             ///< J
  double mechanical_energy = 0.0;          ///< J, zero height at the origin
  pbd::Vec3 momentum = pbd::Vec3::Zero();  ///< kg m/s
  std::uint64_t hash = 0;                  ///< of all poses and twists
};

/// One world on all ranks of MPI ([friston] Sec. 8.3; [preclik2015]). Each dynamic body has one
/// owner, which alone integrates it. Bodies that may touch another rank's are copied there, and the
/// contacts between two ranks are solved by one of the two. In each sweep velocities go there and
/// corrections come back, one message each way per neighbour. Islands that fit a rank are not cut.
/// See docs/scale.md.
///
///     Environment mpi(argc, argv);
///     Cluster cluster;
///     cluster.add(static_def, colliders);      // all ranks alike
///     if (mine(i)) cluster.add(def, colliders);  // each dynamic body on one rank, whichever
///     cluster.start();
///     while (running) cluster.step(1.0 / 60.0);
///
/// All ranks call start(), step(), agree_on(), totals(), save() and load() together. One rank gives
/// the bits of the same world without MPI; any number of ranks gives the same bits in every run
/// with that number. Contacts are the only constraints: joints would have to move with their
/// bodies.
/// @par Thread safety  One thread of each process.
class TANDEM_API Cluster {
 public:
  /// @throws std::invalid_argument if an option is not valid
  explicit Cluster(const ClusterOptions& options = {});
  ~Cluster();
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  int rank() const;
  int count() const;

  /// Register a hull for dynamic bodies: all ranks, in the same order, before start() or load().
  /// @throws std::invalid_argument if it is not a hull, or the cluster has started
  void use(const collision::Hull& hull);
  /// Add a body. Static and kinematic ones: all ranks, in the same order, before start(). Dynamic
  /// ones: one rank, with a unique stable id below 2^63; of spheres, boxes, capsules, cylinders,
  /// cones and hulls of use(). A body added after start() collides with bodies of other ranks from
  /// its second step on.
  /// @param colliders  `body` is set here
  /// @throws std::invalid_argument if that does not hold
  pbd::BodyId add(const pbd::BodyDef& def, std::span<const collision::ColliderDef> colliders);
  /// Distribute the bodies.
  void start();
  /// Advance by dt (s). If a rank is gone, MPI ends all of them.
  const pbd::StepReport& step(double dt);

  /// This rank's bodies, copies of others', and static and kinematic bodies. Pose, twist and forces
  /// of own bodies may be set between steps; bodies are added by add() alone.
  pbd::World& world();
  const pbd::World& world() const;
  const collision::CollisionScene& shapes() const;
  /// Whether this rank owns a body; false for copies.
  bool owns(pbd::BodyId body) const;

  /// The body of a stable id if this rank owns it; else an invalid one.
  pbd::BodyId own_body(std::uint64_t stable_id) const;
  /// All ranks together: returns rank 0's value, such as the time of the step to come.
  std::int64_t agree_on(std::int64_t said);

  const StepCost& cost() const;
  const ClusterState& state() const;
  Totals totals();
  /// Steps since the world began.
  std::uint64_t steps() const;

  /// Write a checkpoint: all ranks into one file, which replaces an earlier one when it is
  /// complete.
  /// @throws std::runtime_error on all ranks if it cannot be written
  void save(const std::string& path);
  /// Instead of adding dynamic bodies and start(): continue from a checkpoint, on any number of
  /// ranks. Static and kinematic bodies must have been added before, as they were then.
  /// @throws std::runtime_error on all ranks if the file is no checkpoint or damaged
  void load(const std::string& path);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::mpi
