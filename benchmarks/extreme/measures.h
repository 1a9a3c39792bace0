// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "copies/session.h"
#include "scene.h"

namespace tandem::extreme_bench {

struct Sample {
  double apart = 0.0;        ///< m, rms over bodies of the largest distance between two copies
  double turned = 0.0;       ///< rad, the same for rotations
  double overlap = 0.0;      ///< m, maximum over copies
  double joint_error = 0.0;  ///< m, maximum over copies
  bool finite = true;
};
Sample sample(const std::vector<std::unique_ptr<peers_bench::Site>>& sites);

/// Kinetic energy and work of one copy, step by step. All J.
///
/// Work is done by gravity and users' springs, none by agreement's displacement. Gravity's comes
/// from velocities by the trapezoidal rule, exact for a constant force (pushing bodies apart adds
/// no energy). Springs' is the mean force over the step times the held point's motion.
class EnergyAccount {
 public:
  explicit EnergyAccount(const peers_bench::Site& site);
  /// Call between Peer::before_step and the solver's step.
  void begun(const peers_bench::Site& site);
  /// Call after the solver's step.
  void stepped(const peers_bench::Site& site, const pbd::StepReport& report, double dt);

  double kinetic = 0.0;
  double work = 0.0;
  double displacement = 0.0;  ///< the solver's account of the displacement channel, largest |value|
  int bad_steps = 0;          ///< that the solver had to undo

 private:
  struct Pull {
    pbd::BodyId body;
    Vec3 arm_l;
    Vec3 at;     ///< m, world, at the start of the step
    Vec3 force;  ///< N, in the last substep
  };
  static double weight_power(const peers_bench::Site& site);

  std::vector<Pull> pulls_;  ///< at the start of the step
  double power_ = 0.0;       ///< W, of gravity, at the start of the step
};

struct Result {
  bool stable = false;
  double peak_mm = 0.0;   ///< or degrees, for scenes by angle
  double final_mm = 0.0;  ///< over the last second, mm or degrees
  int half_frames = -1;   ///< until half of the disagreement is gone for good; -1 = never, or none
  int percent_frames = -1;     ///< until it is below 1 % for good
  int millimetre_frames = -1;  ///< until it is below 1 mm for good
  double overlap_mm = 0.0;
  double overlap_end_mm = 0.0;  ///< mean over the last second
  double joint_mm = 0.0;
  double kinetic_J = 0.0;       ///< maximum over all copies
  double work_J = 0.0;          ///< by hands and gravity up to then
  double excess_J = 0.0;        ///< largest growth of kinetic energy beyond all work
  double displacement_J = 0.0;  ///< largest of any step
};

/// Collects samples and makes a Result of them.
class Watch {
 public:
  Watch(const Scene& scene, peers_bench::Session& session);
  void look();
  Result finish();

 private:
  double difference(const Sample& s) const;

  const Scene& scene_;
  peers_bench::Session& session_;
  std::vector<EnergyAccount> accounts_;
  std::vector<double> lowest_;  ///< m, height of each body at the start, by peer and body
  std::vector<Sample> samples_;
  double start_kinetic_ = 0.0;
  int not_finite_ = 0;  ///< samples, and steps that the solver had to undo
  Result result_;
};

}  // namespace tandem::extreme_bench
