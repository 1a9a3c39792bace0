// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/solver.h"

#include <cmath>
#include <stdexcept>

#include "solver_impl.h"

namespace tandem::pbd {

const StepReport& Solver::Impl::step(World& world, double dt) {
  if (bodies_.rest(world, dt)) {
    world.time_ += dt;
    report_.ran = {};
    report_.stage_s = {};
    return report_;
  }
  begin_step(world, dt);
  begin_groups();
  passes_.run(workers_, clock_, [](GroupPass& pass) {
    for (int i = 0; i < pass.substeps(); ++i) {
      pass.begin_substep(i);
      pass.integrate();
      pass.project();
      pass.advance_poses();
      pass.agree_velocities();
      pass.solve_velocities();
      pass.agree();
    }
  });
  end_groups();
  end_step();
  return report_;
}

const StepReport& Solver::Impl::refuse() {
  report_ = {};
  bodies_.end_rest();
  report_.status = StepStatus::InvalidStep;
  return report_;
}

Solver::Solver(const SolverOptions& options) {
  std::string error;
  if (!options.validate(&error)) throw std::invalid_argument(error);
  impl_ = std::make_unique<Impl>(options);
}
Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

std::string Solver::describe() const { return pbd::describe(impl_->report()); }

const SolverOptions& Solver::options() const { return impl_->options(); }

const StepReport& Solver::step(World& world, double dt) noexcept {
  if (!(dt >= kShortestStep) || !std::isfinite(dt)) return impl_->refuse();
  return impl_->step(world, dt);
}

}  // namespace tandem::pbd
