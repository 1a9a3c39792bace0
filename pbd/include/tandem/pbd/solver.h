// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>

#include "tandem/pbd/contact.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/stage_observer.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {

/// How a step is solved. The defaults are meant for every scene; docs/numerics.md lists what holds.
struct TANDEM_API SolverOptions {
  /// Substeps per step, 1 to 1000, for islands that need no more (see `refine`). The error of
  /// joints falls with its square.
  int substeps = 4;
  /// Sweeps in each substep, 1 to 1000. More substeps are nearly always better.
  int position_iterations = 1;
  /// Largest number of iterations per sweep. Sets of joints are solved until no body moves by more
  /// than the tolerance (m or rad), estimated from the rate of convergence; rods and tethers until
  /// none asks for more than a fiftieth of it. Energy is conserved only if they converge. With the
  /// default tolerance joints are a few micrometres apart without impacts; 1e-6 leaves a tenth of
  /// that.
  int joint_iterations = 20;
  double joint_tolerance = 5e-5;
  /// Sweeps over contact velocities in each substep, at most.
  int velocity_iterations = 1;
  /// m/s: the sweeps stop when no row changes by more.
  double velocity_tolerance = 1e-7;
  ContactOptions contact = {};
  /// Refinement: islands that need it (tall stacks, heavy bodies on light ones, fast joints) get 2
  /// to 32 times as many substeps, for as long as they do.
  bool refine = true;
  /// s: an island that has rested on something for so long sleeps until it is disturbed; 0 = never.
  double sleep_after = 0.5;
  /// m/s, rad/s: bodies slower than this, in the mean over that time, count as at rest.
  double sleep_speed = 1e-3;
  double sleep_spin = 0.01;
  /// Threads that share the work of a stage, 1 to 64. The result has the same bits for any number.
  int threads = 1;
  /// Measure the wall time of each stage.
  bool measure_stages = true;
  /// Called after each stage, for profilers; must outlive the solver. Null costs nothing.
  StageObserver* observer = nullptr;

  /// Whether all fields are valid; if not, `error` names field, value and rule.
  bool validate(std::string* error = nullptr) const;
  friend bool operator==(const SolverOptions&, const SolverOptions&) = default;
};

/// s, the shortest step. Rows carry forces from step to step, that is impulses over the substep's
/// length; with short substeps rounding becomes large forces. Steps of 1/60 and 1e-6 s in turn
/// threw a stack of eight boxes 2.8 m away; down to 1e-5 s it stands.
inline constexpr double kShortestStep = 1e-5;

/// Advances worlds. It holds scratch memory only: all state is in the world. One solver may step
/// many worlds, and a restored world continues as before.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API Solver {
 public:
  /// @throws std::invalid_argument where the options do not validate
  explicit Solver(const SolverOptions& options = {});
  ~Solver();
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;

  const SolverOptions& options() const;

  /// Advance the world by dt. Never throws; allocates only if the world has grown.
  /// @param dt  s, finite and at least kShortestStep; anything else leaves the world as it is: the
  ///   status is StepStatus::InvalidStep
  const StepReport& step(World& world, double dt) noexcept;

  /// Stages that the last step ran and skipped; see describe(const StepReport&).
  std::string describe() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::pbd
