// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A custom constraint, solved in one pass with all others: a hinge with a spring and a damper. A
// rod on it swings as a damped oscillator. docs/constraint.md explains it.
#include <cmath>
#include <cstdio>

#include "tandem/pbd/corrections.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/typed_block.h"

using namespace tandem::pbd;
/// Attaches a body to a point of the world by a hinge along z with spring and damper. C = (p -
/// anchor, rotation vector) [m, rad]; all rows but the angle about z are rigid.
class SpringHinge {
 public:
  static constexpr std::string_view kName = "spring_hinge";
  static constexpr int kOrder = static_cast<int>(SolveOrder::Joint) + 1;
  struct Def {
    BodyId body;
    Vec3 anchor_l = Vec3::Zero();  // m, frame of the body; coincides with the world's origin
    double stiffness = 0.0, damping = 0.0;  // N m/rad, N m s/rad
  };
  static void check(const World& world, const Def& def) {
    detail::require_body(world, def.body, kName, "body");
    detail::require(def.stiffness > 0.0, kName, "stiffness", def.stiffness, "> 0 N m/rad");
  }
  explicit SpringHinge(const Def& def) : def_(def) {}
  const Def& def() const { return def_; }
  Def& def() { return def_; }
  BodyId body_a() const { return {}; }  // the world
  BodyId body_b() const { return def_.body; }
  bool force_driven() const { return true; }  // at rest only while its speed does not change
  double residual() const { return residual_; }
  double displacement_residual() const { return 0.0; }
  void begin_substep(const SubstepContext& ctx) {
    start_ = log_map(ctx.bodies[def_.body.index].q).z();
    lambda_ = 0.0;
  }
  /// One Newton step on all six rows at once. Returns the anchor's error.
  double project(const SubstepContext& ctx) {
    SolverBody& body = ctx.bodies[def_.body.index];
    const Vec3 r = body.q * def_.anchor_l;
    const RowSoftness soft = RowSoftness::of(1.0 / def_.stiffness, def_.damping, ctx.h);
    const double scale = 1.0 / (1.0 + soft.gamma);
    Eigen::Matrix<double, 6, 6> k = Eigen::Matrix<double, 6, 6>::Zero();  // impulses to rows
    k.topLeftCorner<3, 3>() = point_inverse_mass({}, body, Vec3::Zero(), r);
    k.bottomLeftCorner<3, 3>() = body.inv_inertia_w * skew(r);  // LDL^T reads the lower half
    k.bottomRightCorner<3, 3>() = body.inv_inertia_w;
    k(5, 5) += scale * soft.at;
    Eigen::Matrix<double, 6, 1> c;
    c << body.x + r, log_map(body.q);
    c[5] = scale * (c[5] + soft.at * lambda_ + soft.gamma * (c[5] - start_));
    const Eigen::Matrix<double, 6, 1> impulse = -k.ldlt().solve(c);
    apply_correction(body, impulse.head<3>(), r.cross(impulse.head<3>()) + impulse.tail<3>());
    lambda_ += impulse[5];
    return residual_ = c.head<3>().norm();
  }
  void save(ByteWriter& out) const {
    out.u32(def_.body.index);
    out.u32(def_.body.generation);
    out.vec3(def_.anchor_l);
    out.f64(def_.stiffness);
    out.f64(def_.damping);
  }
  void load(ByteReader& in) { def_ = {{in.u32(), in.u32()}, in.vec3(), in.f64(), in.f64()}; }

 private:
  Def def_;
  double start_ = 0.0, lambda_ = 0.0, residual_ = 0.0;  // rad, N m s^2, m
};

int main() {
  constexpr double kMass = 3.0, kStiffness = 16.0, kDamping = 0.8;      // the rod is 1 m long
  const double across = kMass / 12.0, inertia = across + 0.25 * kMass;  // kg m^2
  World world;
  const Quat turned(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  const Vec3 middle(0.5, 0.0, 0.0);
  const BodyId rod = world.add_body({.pose = {.position = turned * middle, .orientation = turned},
                                     .mass = kMass,
                                     .inertia = Vec3(1e-3 * across, across, across).asDiagonal()});
  world.add_block<TypedBlock<SpringHinge>>().add(
      world, {.body = rod, .anchor_l = -middle, .stiffness = kStiffness, .damping = kDamping});
  const double decay = kDamping / (2.0 * inertia);                       // 1/s
  const double omega = std::sqrt(kStiffness / inertia - decay * decay);  // rad/s
  Solver solver({.substeps = 16});
  double worst = 0.0;  // rad
  while (world.time() < 4.0) {
    solver.step(world, 1.0 / 60.0);
    const double t = world.time(),
                 swing = std::cos(omega * t) + decay / omega * std::sin(omega * t);
    const double formula = 0.3 * std::exp(-decay * t) * swing;
    worst = std::fmax(worst, std::abs(log_map(world.pose(rod).orientation).z() - formula));
  }
  const double off = (world.pose(rod).position - world.pose(rod).orientation * middle).norm();
  std::printf("angle within %.4f rad of the formula, hinge within %.2g m\n", worst, off);
  return worst < 0.01 && off < 1e-3 ? 0 : 1;
}
