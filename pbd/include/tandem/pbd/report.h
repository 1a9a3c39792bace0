// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// The stages of a step, in order; the middle ones run once for each substep.
enum class Stage : int { Detect, Begin, Integrate, Project, Velocity, Agree, End };
inline constexpr int kStageCount = 7;
inline constexpr std::array<std::string_view, kStageCount> kStageNames{
    "detect", "begin", "integrate", "project", "velocity", "agree", "end"};

enum class StepStatus : std::uint8_t {
  Ok,
  NonFinite,    ///< a body became NaN or infinite; it was reset to where the step began, at rest
  InvalidStep,  ///< dt is not finite or below kShortestStep: nothing was done
};

/// Effect of agreement on the energy of the world in one step, J.
struct TANDEM_API ConsensusEnergy {
  double displacement = 0.0;        ///< kinetic, carried by the displacement channel; must be 0
  double velocity_agreement = 0.0;  ///< change of kinetic energy by blending velocities
  /// Change of gravitational energy by displacement, and of the rotational energy of spinning
  /// bodies that were turned at constant angular velocity.
  double potential = 0.0;
};

/// Parts of the step that bodies and rows need; the others are skipped.
struct TANDEM_API StepParts {
  bool contacts = false;
  bool friction = false;
  bool restitution = false;
  bool joints = false;      ///< rows that project poses: joints, springs, tethers
  bool rotation = false;    ///< some body turns or may be turned
  bool sleep = false;       ///< bodies are checked for rest
  bool refinement = false;  ///< islands report how many substeps they need
  bool targets = false;
};

/// Report of one step. References are valid until the solver's next step.
struct TANDEM_API StepReport {
  StepStatus status = StepStatus::Ok;
  BodyId first_bad_body = {};  ///< valid where status is NonFinite
  int substeps = 0;            ///< of the group with most
  int bodies = 0;
  int targets = 0;
  int awake = 0;                ///< bodies that were solved
  int stopped = 0;              ///< bodies stopped before they tunnelled
  int groups = 0;               ///< groups of islands, each with its number of substeps
  int velocity_iterations = 0;  ///< over all substeps
  int turning = 0;              ///< bodies whose orientation may change
  int threads = 1;
  std::array<bool, kStageCount> ran{};  ///< whether the stage had anything to do
  StepParts parts = {};
  std::array<double, kStageCount> stage_s{};  ///< wall time of each stage, s
  std::vector<BlockReport> blocks = {};       ///< rows and residuals, in solve order
  ConsensusEnergy energy = {};

  double total_s() const {
    double sum = 0.0;
    for (const double s : stage_s) sum += s;
    return sum;
  }
};

/// A few lines on what the step ran and what it left out: stages, parts, blocks, threads.
TANDEM_API std::string describe(const StepReport& report);

}  // namespace tandem::pbd
