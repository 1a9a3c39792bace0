// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_six_dof.h"

#include "joint_spring.h"

namespace tandem::pbd::joint_six_dof {
namespace {

constexpr std::uint32_t kNone = JointGraph::kNone;
/// Bound on the gradient of an angle. Twist and swing have none at half a turn of swing: the rest
/// of a torque there turns bodies by a fraction of its value.
constexpr double kSteepest = 2.0;
/// Rate of a coordinate.
double rate_of(const JointRows& rows, int i, const SolverBody& a, const SolverBody& b) {
  return rows.dir.col(i).dot(b.v - a.v) + rows.arm_b.col(i).dot(b.w) - rows.arm_a.col(i).dot(a.w);
}

}  // namespace

void take_gradients(JointNode& node, JointRows& rows, const JointRecord& record,
                    const SolverBody& a, const SolverBody& b) {
  const SixDofJointDef& def = record.def;
  const JointPlace place = JointPlace::of(def, a, b);
  node.r_a = place.r_a;
  node.r_b = place.r_b;
  if (record.point) {
    rows.dir.leftCols<3>().setIdentity();
    rows.arm_a.leftCols<3>() = skew(place.r_a);
    rows.arm_b.leftCols<3>() = skew(place.r_b);
    if (record.is_point()) return;
  }
  const Quat basis_a = a.q * def.frame_a.basis;
  const Mat3 axes = basis_a.toRotationMatrix();
  if (!record.point) {
    for (int i = 0; i < 3; ++i) {
      rows.dir.col(i) = axes.col(i);
      rows.arm_a.col(i) = Vec3(place.r_a + place.d).cross(axes.col(i));
      rows.arm_b.col(i) = place.r_b.cross(axes.col(i));
    }
  }
  if ((record.used >> 3) != 0) {
    const Quat rel = basis_a.conjugate() * (b.q * def.frame_b.basis);
    const JointTurn turn = JointTurn::of(turned_axes(rel, record.turning));
    Mat3 named;  // the axes as named in `turn`
    for (int i = 0; i < 3; ++i) named.col(i) = axes.col((record.turning + i) % 3);
    rows.dir.rightCols<kCoordinates - 3>().setZero();
    rows.arm_b.col(record.turn(0)) = named * turn.twist_gradient();
    rows.arm_b.col(record.turn(1)) = named * turn.swing_gradient(1);
    rows.arm_b.col(record.turn(2)) = named * turn.swing_gradient(2);
    rows.arm_b.col(kCone) = named * turn.u;  // has a row only if x is x
    for (int i = 3; i < kCone; ++i) {
      const double size = rows.arm_b.col(i).norm();
      if (size > kSteepest && record.axis(i).freedom != Freedom::Locked)
        rows.arm_b.col(i) *= kSteepest / size;
    }
    if ((record.used >> kDrive) != 0) rows.arm_b.rightCols<3>() = axes;
    rows.arm_a.rightCols<kCoordinates - 3>() = rows.arm_b.rightCols<kCoordinates - 3>();
  }
}

void begin(const JointPart& part) {
  const SolverBody ground;
  const SubstepContext& ctx = part.ctx;
  part.for_nodes([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    node.n = 0;
    if (plan.joint == kNone) {
      node.n = plan.rows;
      return;
    }
    JointRecord& record = part.records[plan.joint];
    node.off = !record.active();
    if (node.off) return;
    const SolverBody& a = body_of(record.def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(record.def.b, ctx.bodies, ground);
    const bool left = ctx.substep > 0 && (a.pushed || b.pushed);
    const bool displaced = a.shared || b.shared;
    JointRows& rows = part.all.rows[k];
    node.lambda.fill(0.0);
    node.warm = false;
    node.lambda_start.fill(0.0);
    rows.stops = 0;
    double c[kCoordinates];
    if ((record.used >> kDrive) != 0 && part.progress.channel == JointChannel::Real)
      record.begin_drive(a, b, ctx.h);
    coordinates(record, a, b, record.twist, c);
    if ((record.used >> record.turn(0) & 1u) != 0 && part.progress.channel == JointChannel::Real)
      record.twist = c[record.turn(0)];
    take_gradients(node, rows, record, a, b);
    node.pull_a = node.pull_b = 0.0;
    node.add_pull(plan, ctx.h * ctx.h * record.state.force);
    std::copy_n(c, kCoordinates, rows.start.begin());
    for_bits(record.used, [&](int i) {
      const JointAxis& axis = record.axis(i);
      if (part.progress.channel == JointChannel::Displacement) {
        rows.law[i] = displacement_law(axis, record.bound[i], ctx.h);
        return;
      }
      double& residual = record.displacement_residual[i];
      residual = (record.in_part >> i & 1u) != 0
                     ? residual_of(axis, c[i])
                     : residual_at_start(axis, c[i], residual, left, displaced, ctx.h, kLeft);
      set_force_law(rows.law[i], axis, c[i], residual, ctx.h);
      if (axis.spring.frequency > 0.0) {
        tune_spring(rows.law[i], axis.spring, record.spring_mass[i], c[i], rate_of(rows, i, a, b),
                    ctx.h);
      }
      if (axis.armature > 0.0) {
        const double rate =
            record.last.rotors_known ? record.last.rotors[i] : rate_of(rows, i, a, b);
        add_armature(rows.law[i], axis.armature, c[i] + ctx.h * rate);
      }
    });
  });
}

void take_gradients(const JointPart& part) {
  const SolverBody ground;
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    const JointRecord& record = part.records[plan.joint];
    take_gradients(node, part.all.rows[k], record, body_of(record.def.a, part.ctx.bodies, ground),
                   body_of(record.def.b, part.ctx.bodies, ground));
  });
}

void weigh(const JointPart& part) {
  const std::vector<JointSlot>& slots = part.all.slots;
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, const JointNode&) {
    JointRows& rows = part.all.rows[k];
    double inv_mass = 0.0;
    if (plan.slot_a != kNone) inv_mass += slots[plan.slot_a].inv_mass;
    if (plan.slot_b != kNone) inv_mass += slots[plan.slot_b].inv_mass;
    for_bits(part.records[plan.joint].used, [&](int i) {
      double w = inv_mass * rows.dir.col(i).squaredNorm();
      if (plan.slot_a != kNone) {
        rows.b_a.col(i) = slots[plan.slot_a].inv_inertia * rows.arm_a.col(i);
        w += rows.arm_a.col(i).dot(rows.b_a.col(i));
      }
      if (plan.slot_b != kNone) {
        rows.b_b.col(i) = slots[plan.slot_b].inv_inertia * rows.arm_b.col(i);
        w += rows.arm_b.col(i).dot(rows.b_b.col(i));
      }
      rows.w[i] = w;
    });
  });
}

namespace {

/// Motion of the bodies relative to each other in the substep, by velocities and corrections.
struct RelativeMove {
  Vec3 way, turn_a, turn_b;  ///< m, rad

  RelativeMove(const SolverBody& a, const SolverBody& b, double h)
      : way(h * (b.v - a.v) + b.dx - a.dx),
        turn_a(h * a.w + a.dtheta),
        turn_b(h * b.w + b.dtheta) {}
  double along(const JointRows& rows, int i) const {
    return rows.dir.col(i).dot(way) + rows.arm_b.col(i).dot(turn_b) - rows.arm_a.col(i).dot(turn_a);
  }
};

/// Bounds the difference of a coordinate from its linear prediction by the turn of the bodies. It
/// is larger beyond half a turn of swing, where twist and swing jump. See JointProgress::linear.
void see_in_part(const JointPart& part, JointRecord& record, const JointRows& rows,
                 const SolverBody& a, const SolverBody& b, double* c) {
  if (part.progress.channel != JointChannel::Real) return;
  const RelativeMove move(a, b, part.ctx.h);
  const double most = part.progress.linear ? 0.0 : (move.turn_b - move.turn_a).norm();
  record.in_part = 0;
  for_bits(record.used, [&](int i) {
    if (rows.law[i].locked || (i < 3 && !part.progress.linear)) return;
    const double at = rows.start[i] + move.along(rows, i);
    const double seen = std::clamp(c[i], at - most, at + most);
    if (seen != c[i]) record.in_part |= 1u << i;
    c[i] = seen;
  });
}

}  // namespace

bool evaluate(const JointPart& part) {
  bool changed = false;
  const SolverBody ground;
  part.for_nodes([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    double* right = &part.all.right[plan.right];
    if (plan.joint == kNone) {
      std::fill_n(right, plan.rows, 0.0);
      return;
    }
    if (node.off) return;
    JointRows& rows = part.all.rows[k];
    JointRecord& record = part.records[plan.joint];
    const SolverBody& a = body_of(record.def.a, part.ctx.bodies, ground);
    const SolverBody& b = body_of(record.def.b, part.ctx.bodies, ground);
    double c[kCoordinates];
    coordinates(record, a, b, record.twist, c);
    see_in_part(part, record, rows, a, b, c);
    rows.stops = 0;
    int n = 0;
    for_bits(record.used, [&](int i) {
      using Kind = Segment::Kind;
      if (node.warm && rows.law[i].is_corner(node.lambda[i])) return;
      Segment segment = rows.law[i].segment(c[i], node.lambda[i]);
      if (segment.kind == Kind::Lower || segment.kind == Kind::Upper) rows.stops |= 1u << i;
      if (segment.kind == Kind::None || (segment.kind != Kind::Lock && !(rows.w[i] > 0.0))) return;
      if (!part.plan.regular)
        segment.at = std::max(segment.at, part.progress.redundancy * rows.w[i]);
      changed =
          changed || n >= node.n || rows.coordinate[n] != i || rows.segment[n].kind != segment.kind;
      if (rows.law[i].servo_k > 0.0) changed = changed || rows.segment[n].at != segment.at;
      rows.coordinate[n] = static_cast<std::uint8_t>(i);
      rows.segment[n] = segment;
      node.at[n] = segment.at;
      right[n] = rows.left[n] = segment.left(c[i], node.lambda[i]);
      ++n;
    });
    changed = changed || n != node.n;
    node.n = n;
    node.warm = false;
  });
  return changed;
}

double supplied(const JointPart& part) {
  const SolverBody ground;
  double sum = 0.0;
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, const JointNode& node) {
    const JointRows& rows = part.all.rows[k];
    const JointRecord& record = part.records[plan.joint];
    const RelativeMove move(body_of(record.def.a, part.ctx.bodies, ground),
                            body_of(record.def.b, part.ctx.bodies, ground), part.ctx.h);
    for_bits(record.used, [&](int i) {
      if (rows.law[i].powered) sum += std::max(0.0, node.lambda[i] * move.along(rows, i));
    });
  });
  return sum / (part.ctx.h * part.ctx.h);
}

namespace {

/// Sums the moves of the step per body.
void gather_moves(const JointPart& part) {
  std::vector<JointSlot>& slots = part.all.slots;
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, const JointNode& node) {
    if (node.n == 0) return;
    const JointRows& rows = part.all.rows[k];
    const double* dlambda = &part.all.right[plan.right];
    Vec3 p = Vec3::Zero();
    Vec3 turn_a = Vec3::Zero();
    Vec3 turn_b = Vec3::Zero();
    for (int r = 0; r < node.n; ++r) {
      const int i = rows.coordinate[r];
      p += dlambda[r] * rows.dir.col(i);
      if (plan.slot_a != kNone) turn_a += dlambda[r] * rows.b_a.col(i);
      if (plan.slot_b != kNone) turn_b += dlambda[r] * rows.b_b.col(i);
    }
    if (plan.slot_a != kNone) {
      JointSlot& slot = slots[plan.slot_a];
      slot.dx -= slot.inv_mass * p;
      slot.dtheta -= turn_a;
    }
    if (plan.slot_b != kNone) {
      JointSlot& slot = slots[plan.slot_b];
      slot.dx += slot.inv_mass * p;
      slot.dtheta += turn_b;
    }
  });
}

/// Calls visit(node, plan, rows, r, step) for all rows.
void for_rows(const JointPart& part, auto&& visit) {
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    double* step = &part.all.right[plan.right];
    for (int r = 0; r < node.n; ++r) visit(node, plan, part.all.rows[k], r, step[r]);
  });
}

/// Change of a row by the moves.
double change_of(const JointPart& part, const JointGraph::Node& plan, const JointRows& rows, int r,
                 double step) {
  const int i = rows.coordinate[r];
  double change = rows.segment[r].at * step;
  if (plan.slot_a != kNone) {
    const JointSlot& slot = part.all.slots[plan.slot_a];
    change -= rows.dir.col(i).dot(slot.dx) + rows.arm_a.col(i).dot(slot.dtheta);
  }
  if (plan.slot_b != kNone) {
    const JointSlot& slot = part.all.slots[plan.slot_b];
    change += rows.dir.col(i).dot(slot.dx) + rows.arm_b.col(i).dot(slot.dtheta);
  }
  return change;
}

/// Cuts the step, and its moves, at the first corner.
void take_first_corner(const JointPart& part) {
  double reach = 1.0;
  for_rows(part, [&](const JointNode&, const JointGraph::Node&, const JointRows& rows, int r,
                     double step) {
    if (step != rows.newton[r]) reach = std::min(reach, step / rows.newton[r]);
  });
  for_rows(part,
           [&](const JointNode&, const JointGraph::Node&, JointRows& rows, int r, double& step) {
             rows.pinned[r] = step != rows.newton[r] && step / rows.newton[r] <= reach;
             if (!rows.pinned[r]) step = reach * rows.newton[r];
           });
  part.for_bodies([](JointSlot& slot, const SolverBody&) {
    slot.dx.setZero();
    slot.dtheta.setZero();
  });
  gather_moves(part);
}

}  // namespace

void warm_start(const JointPart& part, bool brakes_only) {
  const double h2 = part.ctx.h * part.ctx.h;
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    JointRows& rows = part.all.rows[k];
    double* right = &part.all.right[plan.right];
    node.n = 0;
    for_bits(part.records[plan.joint].used, [&](int i) {
      const double lambda = rows.law[i].nearest(h2 * part.records[plan.joint].last.forces[i]);
      if (lambda == 0.0 || (brakes_only && !rows.law[i].is_corner(lambda))) return;
      rows.coordinate[node.n] = static_cast<std::uint8_t>(i);
      right[node.n++] = node.lambda[i] = lambda;
    });
    node.warm = node.n > 0 && part.plan.regular;
  });
  gather_moves(part);
}

bool gather(const JointPart& part) {
  bool whole = true;
  for_rows(part, [&](const JointNode& node, const JointGraph::Node&, JointRows& rows, int r,
                     double& step) {
    const Segment& segment = rows.segment[r];
    rows.newton[r] = step;
    const double lambda = node.lambda[rows.coordinate[r]];
    const double next = lambda + step;
    rows.pinned[r] = next < segment.low || next > segment.high;
    if (!rows.pinned[r]) return;
    whole = false;
    step = (next < segment.low ? segment.low : segment.high) - lambda;
  });
  gather_moves(part);
  if (!whole) {
    // The minimised function changes by curvature / 2 - slope.
    double slope = 0.0;
    double curvature = 0.0;
    for_rows(part, [&](const JointNode&, const JointGraph::Node& plan, const JointRows& rows, int r,
                       double step) {
      slope += step * rows.left[r];
      curvature += step * change_of(part, plan, rows, r, step);
    });
    if (!(slope > 0.5 * curvature)) take_first_corner(part);
  }
  for_rows(part,
           [&](JointNode& node, const JointGraph::Node& plan, JointRows& rows, int r, double step) {
             double& lambda = node.lambda[rows.coordinate[r]];
             if (!whole) rows.left[r] -= change_of(part, plan, rows, r, step);
             lambda += step;
             if (rows.pinned[r])
               lambda = step == 0.0            ? lambda
                        : rows.newton[r] < 0.0 ? rows.segment[r].low
                                               : rows.segment[r].high;
           });
  return whole;
}

void pin(const JointPart& part) {
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    JointRows& rows = part.all.rows[k];
    double* right = &part.all.right[plan.right];
    int n = 0;
    for (int r = 0; r < node.n; ++r) {
      if (rows.pinned[r]) continue;
      rows.coordinate[n] = rows.coordinate[r];
      rows.segment[n] = rows.segment[r];
      node.at[n] = node.at[r];
      right[n] = rows.left[n] = rows.left[r];
      ++n;
    }
    node.n = n;
  });
  part.for_nodes([&](std::uint32_t, const JointGraph::Node& plan, const JointNode&) {
    if (plan.joint == kNone) std::fill_n(&part.all.right[plan.right], plan.rows, 0.0);
  });
}

}  // namespace tandem::pbd::joint_six_dof
