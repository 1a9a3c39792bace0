// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "measure/quality.h"
#include "tandem/pbd/math.h"

/// Shared measures of the cases, and the independent references.
namespace tandem::bench {

/// Calls `watch(time at the end of the frame)` after each frame.
inline void run_scene(const Scene& scene, Engine& engine,
                      const std::function<void(double)>& watch = {}) {
  for (int i = 0; i < scene.frames(); ++i) {
    engine.step(scene.dt);
    if (watch) watch((i + 1) * scene.dt);
  }
}

/// Energy of a passive scene, relative to the floor, its lowest possible value.
class EnergyWatch {
 public:
  /// @param floor  J, the scene's minimum of potential energy
  EnergyWatch(const Scene& scene, const Engine& engine, double floor)
      : scene_(scene), start_(mechanical_energy(scene, engine)), total_(start_ - floor) {}
  void after_frame(const Engine& engine) {
    const double change = (mechanical_energy(scene_, engine) - start_) / total_;
    // std::max would drop a NaN.
    growth_ = std::isnan(change) ? change : std::max(growth_, change);
    drift_ = std::isnan(change) ? change : std::max(drift_, std::abs(change));
  }
  double growth() const { return growth_; }  ///< largest gain over the start, relative to the total
  double drift() const { return drift_; }    ///< largest change either way, relative to the total

 private:
  const Scene& scene_;
  double start_;
  double total_;
  double growth_ = 0.0;
  double drift_ = 0.0;
};

/// Potential energy (J) of the scene with all moving bodies' centres at height `z` (m).
inline double energy_at_height(const Scene& scene, double z) {
  double mass = 0.0;
  for (const SceneBody& body : scene.bodies) {
    if (body.type == BodyType::Dynamic) mass += body.mass;
  }
  return mass * scene.gravity.norm() * z;
}

/// Angular momentum (kg m^2/s) of body `i` about its own centre.
inline Vec3 spin_momentum(const Scene& scene, const Engine& engine, int i) {
  const pbd::BodyState state = engine.state(i);
  const Vec3 w_l = state.pose.orientation.conjugate() * state.twist.angular;
  return state.pose.orientation *
         scene.bodies[static_cast<std::size_t>(i)].inertia.cwiseProduct(w_l);
}

/// Complete elliptic integral of the first kind K(k) by the arithmetic-geometric mean.
inline double elliptic_k(double k) {
  double a = 1.0;
  double b = std::sqrt(1.0 - k * k);
  while (std::abs(a - b) > 1e-15 * a) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi / (2.0 * a);
}

/// Period (s) of a symmetric signal about 0 sampled each dt, by interpolated crossings. 0 with
/// fewer than two.
inline double crossing_period(const std::vector<double>& x, double dt) {
  std::vector<double> times;
  for (std::size_t i = 1; i < x.size(); ++i) {
    if ((x[i - 1] < 0.0) != (x[i] < 0.0)) {
      times.push_back(dt * (static_cast<double>(i) - x[i] / (x[i] - x[i - 1])));
    }
  }
  if (times.size() < 2) return 0.0;
  return 2.0 * (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

/// Period (s) of a damped sinusoid, with more than two samples per period: least squares on x[n+1]
/// = c x[n] - d x[n-1] (Prony's method). 0 if it does not oscillate.
inline double sinusoid_period(const std::vector<double>& x, double dt) {
  double s11 = 0.0, s12 = 0.0, s22 = 0.0, r1 = 0.0, r2 = 0.0;
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    s11 += x[i] * x[i];
    s12 -= x[i] * x[i - 1];
    s22 += x[i - 1] * x[i - 1];
    r1 += x[i] * x[i + 1];
    r2 -= x[i - 1] * x[i + 1];
  }
  const double determinant = s11 * s22 - s12 * s12;
  const double c = (r1 * s22 - r2 * s12) / determinant;
  const double d = (s11 * r2 - s12 * r1) / determinant;
  const double cosine = 0.5 * c / std::sqrt(d);
  if (!(std::abs(cosine) < 1.0)) return 0.0;
  return 2.0 * std::numbers::pi * dt / std::acos(cosine);
}

/// Largest horizontal distance (m) of body `i` from its start.
inline double horizontal_drift(const Scene& scene, const Engine& engine, int i) {
  return (engine.state(i).pose.position - scene.bodies[static_cast<std::size_t>(i)].pose.position)
      .head<2>()
      .norm();
}

inline Pose at(double x, double y, double z) { return {.position = Vec3(x, y, z)}; }

inline BoxShape cube(double side) { return {Vec3::Constant(0.5 * side)}; }

}  // namespace tandem::bench
