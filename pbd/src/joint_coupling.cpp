// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/joint_coupling.h"

#include <Eigen/Cholesky>

#include "byte_fields.h"
#include "joint_rows.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Rows: five held by each joint, then the coupling.
constexpr int kHeld = 5;
constexpr int kRows = 2 * kHeld + 1;
constexpr JointAxis kLock{.freedom = Freedom::Locked};

/// Current place of a joint.
struct Place {
  SolverBody* a;
  SolverBody* b;
  Vec3 r_a, r_b;  ///< m; from a's centre to the anchor of b
  Mat3 axes;      ///< of frame a, world
  double at;      ///< m or rad

  Place(const JointCoupling::Side& side, const SubstepContext& ctx, SolverBody& ground,
        double near) {
    a = side.a.valid() ? &ctx.bodies[side.a.index] : &ground;
    b = &ctx.bodies[side.b.index];
    const Quat basis = a->q * side.frame_a.basis;
    axes = basis.toRotationMatrix();
    r_b = rotate(b->q, side.frame_b.anchor);
    r_a = b->x + r_b - a->x;
    if (side.slides) {
      at = axes.col(0).dot(r_a - rotate(a->q, side.frame_a.anchor));
    } else {
      const Quat rel = basis.conjugate() * (b->q * side.frame_b.basis);
      at = nearest_turn(2.0 * portable::atan2(rel.x(), rel.w()), near);
    }
  }
};

/// Gradients of all rows with respect to the motion of up to four bodies.
struct Rows {
  std::array<SolverBody*, 4> bodies{};
  int count = 0;
  Eigen::Matrix<double, 24, kRows> gradient = Eigen::Matrix<double, 24, kRows>::Zero();

  int slot(SolverBody* body) {
    for (int i = 0; i < count; ++i) {
      if (bodies[static_cast<std::size_t>(i)] == body) return 6 * i;
    }
    bodies[static_cast<std::size_t>(count)] = body;
    return 6 * count++;
  }
  /// Adds coordinate i of a joint (an index into JointState::position), times `share`.
  void add(const Place& place, int i, int row, double share) {
    const int a = slot(place.a);
    const int b = slot(place.b);
    const Vec3 axis = share * place.axes.col(i % 3);
    const bool turns = i >= 3;
    if (!turns) {
      gradient.block<3, 1>(b, row) += axis;
      gradient.block<3, 1>(a, row) -= axis;
    }
    gradient.block<3, 1>(b + 3, row) += turns ? axis : Vec3(place.r_b.cross(axis));
    gradient.block<3, 1>(a + 3, row) -= turns ? axis : Vec3(place.r_a.cross(axis));
  }
  /// Moves the bodies so that the last row changes by `change`, and no other row does.
  void move(double change) const {
    Eigen::Matrix<double, 24, kRows> moves = gradient;
    for (int i = 0; i < count; ++i) {
      const SolverBody& body = *bodies[static_cast<std::size_t>(i)];
      moves.middleRows<3>(6 * i) *= body.inv_mass;
      for (int row = 0; row < kRows; ++row) {
        moves.block<3, 1>(6 * i + 3, row) =
            Vec3(body.inv_inertia_w * gradient.block<3, 1>(6 * i + 3, row));
      }
    }
    const Eigen::Matrix<double, kRows, kRows> k = gradient.transpose() * moves;
    Eigen::Matrix<double, kRows, 1> wanted = Eigen::Matrix<double, kRows, 1>::Zero();
    wanted[kRows - 1] = change;
    const Eigen::Matrix<double, kRows, 1> lambda = k.ldlt().solve(wanted);
    if (!lambda.allFinite()) return;  // no body can move it
    const Eigen::Matrix<double, 24, 1> impulse = gradient * lambda;
    for (int i = 0; i < count; ++i) {
      apply_correction(*bodies[static_cast<std::size_t>(i)], impulse.segment<3>(6 * i),
                       impulse.segment<3>(6 * i + 3));
    }
  }
};

void side_fields(auto& io, auto& side) {
  io(side.a, side.b, side.frame_a.anchor, side.frame_a.basis, side.frame_b.anchor,
     side.frame_b.basis, side.slides, side.start);
}

void check_side(const World& world, const JointCoupling::Side& side) {
  constexpr std::string_view kName = JointCoupling::kName;
  if (side.a.valid()) detail::require_body(world, side.a, kName, "a");
  detail::require_body(world, side.b, kName, "b");
  detail::require(side.a != side.b, kName, "b", side.b.index, "another body than a");
  for (const JointFrame* frame : {&side.frame_a, &side.frame_b}) {
    detail::require_finite(frame->anchor, kName, "anchor");
    detail::require_unit(frame->basis, kName, "basis");
  }
  detail::require(std::isfinite(side.start), kName, "start", side.start, "finite");
}

}  // namespace

JointCoupling::Def JointCoupling::between(const JointBlock& joints, JointId one, JointId two,
                                          double ratio, double offset) {
  const auto side = [&](JointId id) {
    const SixDofJointDef& def = joints.def(id);
    const bool slides = def.linear[0].freedom != Freedom::Locked;
    const double at = slides ? joints.slider_position(id) : joints.hinge_angle(id);
    return Side{def.a, def.b, def.frame_a, def.frame_b, slides, at};
  };
  return {.one = side(one), .two = side(two), .ratio = ratio, .offset = offset};
}

void JointCoupling::check(const World& world, const Def& def) {
  check_side(world, def.one);
  check_side(world, def.two);
  detail::require(def.one.b != def.two.b, kName, "two.b", def.two.b.index,
                  "another body than one.b");
  detail::require(std::isfinite(def.ratio), kName, "ratio", def.ratio, "finite");
  detail::require(std::isfinite(def.offset), kName, "offset", def.offset, "finite");
}

bool JointCoupling::names(BodyId body) const {
  return body == def_.one.a || body == def_.one.b || body == def_.two.a || body == def_.two.b;
}

void JointCoupling::append_edges(std::vector<ConstraintEdge>& edges) const {
  for (const Side* side : {&def_.one, &def_.two}) {
    edges.push_back({.body_a = side->a.index, .body_b = side->b.index});
  }
}

double JointCoupling::violated(const SubstepContext& ctx) {
  SolverBody ground;
  near_[0] = Place(def_.one, ctx, ground, near_[0]).at;
  near_[1] = Place(def_.two, ctx, ground, near_[1]).at;
  return near_[1] - def_.ratio * near_[0] - def_.offset;
}

double JointCoupling::solve(const SubstepContext& ctx, double target) {
  SolverBody ground;
  const Place one(def_.one, ctx, ground, near_[0]);
  const Place two(def_.two, ctx, ground, near_[1]);
  near_ = {one.at, two.at};
  const double change = target - (two.at - def_.ratio * one.at - def_.offset);
  Rows rows;
  for (int i = 0, row = 0; i < 6; ++i) {
    if (i != def_.one.coordinate()) rows.add(one, i, row++, 1.0);
  }
  for (int i = 0, row = kHeld; i < 6; ++i) {
    if (i != def_.two.coordinate()) rows.add(two, i, row++, 1.0);
  }
  rows.add(one, def_.one.coordinate(), kRows - 1, -def_.ratio);
  rows.add(two, def_.two.coordinate(), kRows - 1, 1.0);
  rows.move(change);
  return std::abs(change);
}

void JointCoupling::forgive(const SubstepContext& ctx) { displacement_residual_ = violated(ctx); }

bool JointCoupling::find_gap(const SubstepContext& ctx) {
  SolverBody& one = ctx.bodies[def_.one.b.index];
  SolverBody& two = ctx.bodies[def_.two.b.index];
  if (one.agreed || two.agreed) {  // as in joints
    gap_ = {};
    return false;
  }
  const double off = violated(ctx);
  if (std::abs(off) > residual_ + JointGap::kTolerance) gap_.open(std::abs(off));
  if (!gap_.is_open()) return false;
  displacement_residual_ = off;
  bool marked = false;
  for (SolverBody* body : {&one, &two}) {
    if (body->is_solved()) marked = body->shared = true;
  }
  return marked;
}

void JointCoupling::begin_substep(const SubstepContext& ctx) {
  const SolverBody& one = ctx.bodies[def_.one.b.index];
  const SolverBody& two = ctx.bodies[def_.two.b.index];
  const bool left = ctx.substep > 0 && (one.pushed || two.pushed);
  displacement_residual_ = residual_at_start(kLock, violated(ctx), displacement_residual_, left,
                                             one.shared || two.shared, ctx.h);
}

double JointCoupling::project(const SubstepContext& ctx) {
  return solve(ctx, displacement_residual_);
}

void JointCoupling::begin_displacement(const SubstepContext& ctx) {
  const bool agreed = ctx.bodies[def_.one.b.index].agreed || ctx.bodies[def_.two.b.index].agreed;
  const double reach = agreed ? HUGE_VAL : ctx.h * (def_.two.slides ? kClosingSpeed : kClosingSpin);
  const double now = std::clamp(displacement_residual_, -reach, reach);
  bound_ = violated(ctx) - now;
  displacement_residual_ -= now;
}

double JointCoupling::project_displacement(const SubstepContext& ctx) { return solve(ctx, bound_); }

void JointCoupling::end_displacement(const SubstepContext& ctx) {
  displacement_residual_ = gap_left(kLock, violated(ctx), bound_, displacement_residual_);
}

void JointCoupling::end_step(const SubstepContext& ctx) {
  residual_ = std::abs(violated(ctx));
  if (!def_.enabled) displacement_residual_ = residual_ = 0.0;
  // A non-finite step must not spoil the next one.
  for (double* value : {&displacement_residual_, &residual_, &near_[0], &near_[1]}) {
    if (!std::isfinite(*value)) *value = 0.0;
  }
  gap_.settle(std::abs(displacement_residual_));
}

void JointCoupling::save(ByteWriter& out) const {
  FieldWriter io(out);
  side_fields(io, def_.one);
  side_fields(io, def_.two);
  io(def_.ratio, def_.offset, def_.enabled, near_[0], near_[1], displacement_residual_, residual_,
     gap_.least, gap_.stalled);
}

void JointCoupling::load(ByteReader& in) {
  FieldReader io(in);
  side_fields(io, def_.one);
  side_fields(io, def_.two);
  io(def_.ratio, def_.offset, def_.enabled, near_[0], near_[1], displacement_residual_, residual_,
     gap_.least, gap_.stalled);
  bool finite = gap_.least >= 0.0;
  for (const double value : {near_[0], near_[1], displacement_residual_, residual_, gap_.least}) {
    finite = finite && std::isfinite(value);
  }
  if (!finite) in.fail();
}

}  // namespace tandem::pbd
