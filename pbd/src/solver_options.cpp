// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <string>

#include "tandem/pbd/solver.h"
#include "tandem/pbd/validate.h"

namespace tandem::pbd {
namespace {

bool in_range(double value, double low, double high, const char* field, std::string* error) {
  return detail::in_range(value, low, high, std::string("SolverOptions: ") + field, error);
}

}  // namespace

bool SolverOptions::validate(std::string* error) const {
  return in_range(substeps, 1, 1000, "substeps", error) &&
         in_range(position_iterations, 1, 1000, "position_iterations", error) &&
         in_range(joint_iterations, 1, 1000, "joint_iterations", error) &&
         in_range(joint_tolerance, 0.0, 1.0, "joint_tolerance", error) &&
         in_range(velocity_iterations, 0, 1000, "velocity_iterations", error) &&
         in_range(velocity_tolerance, 0.0, 1.0, "velocity_tolerance", error) &&
         in_range(sleep_after, 0.0, 1e6, "sleep_after", error) &&
         in_range(sleep_speed, 0.0, 1e6, "sleep_speed", error) &&
         in_range(sleep_spin, 0.0, 1e6, "sleep_spin", error) &&
         in_range(threads, 1, 64, "threads", error) &&
         in_range(contact.extra_rows, 0, 1e9, "contact.extra_rows", error) &&
         in_range(contact.extra_sweeps, 0, 1e9, "contact.extra_sweeps", error) &&
         in_range(contact.resting_tolerance, 0.0, 1e6, "contact.resting_tolerance", error) &&
         in_range(contact.push_speed, 0.0, 1e6, "contact.push_speed", error) &&
         in_range(contact.warm_start_gap, 0.0, 1.0, "contact.warm_start_gap", error) &&
         in_range(contact.restitution_threshold, 0.0, 1e6, "contact.restitution_threshold",
                  error) &&
         in_range(contact.lanes, 0, 4, "contact.lanes", error);
}

}  // namespace tandem::pbd
