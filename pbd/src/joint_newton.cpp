// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "integrate.h"
#include "joint_system.h"

/// The Newton iteration of JointSystem: rows from poses, poses from multipliers.
namespace tandem::pbd {
namespace {

/// Loops that add energy are solved again with this much more compliance, so often at most.
constexpr double kSofter = 100.0;
constexpr int kSoften = 2;
/// Moves that shrink less than this from iteration to iteration call for a better matrix.
constexpr double kSlow = 0.3;
/// m; smaller moves are rounding as like as not.
constexpr double kFine = 1e-7;
/// rad; bodies turn no further in one iteration.
constexpr double kTrust = 0.5;
/// How often a limit may come and go within a substep.
constexpr int kFlips = 6;
/// rad: smaller turns do not matter.
constexpr double kNoTurn = 1e-13;

/// Moves that shrink as those of a matrix that stays go on to do so: what they have left to go.
double rest_of(double move, double before) {
  const double rate = move / before;
  return rate < kSlow ? move * rate / (1.0 - rate) : move;
}

}  // namespace

double JointSystem::iterate(std::uint32_t p, std::span<const JointRecord> records,
                            const SubstepContext& ctx) {
  const JointGraph::Part& part = graph_.parts()[p];
  PartState& state = state_[p];
  if (state.channel == Channel::Displacement) {
    // Bodies go as far as their targets, so each iteration takes the gradients where they are; and
    // the clean-up, which comes last, has the bodies' own masses again.
    turn_gradients(part, records, ctx);
    prepare(part, state, records, ctx);
    return newton(part, state, records, ctx);
  }
  if (!state.prepared) {
    prepare(part, state, records, ctx);
  } else if (state.position_iteration != ctx.iteration) {
    begin_iteration(part, state, ctx);
  }
  const double before = state.last_move;
  state.last_move = newton(part, state, records, ctx);
  const auto is_slow = [&] {
    return state.iteration > 1 && state.last_move > kSlow * before && state.last_move > kFine;
  };
  const auto start_anew = [&](bool learn) {
    restart(part, records, ctx, learn);
    state.iteration = 0;
    prepare(part, state, records, ctx);
    state.last_move = newton(part, state, records, ctx);
  };
  const bool may_soften = !part.regular && passive_[p] != 0 && state.softened < kSoften;
  if (may_soften && adds_energy(part, ctx)) {
    ++state.softened;
    state.redundancy *= kSofter;
    start_anew(false);
  } else if (is_slow() && !state.restarted) {
    state.restarted = true;
    start_anew(true);
  } else if (is_slow()) {
    turn_gradients(part, records, ctx);
    if (!part.points) weigh(part, records);
    state.factored = false;
  }
  return state.iteration > 1 && !state.changed ? rest_of(state.last_move, before) : state.last_move;
}

double JointSystem::newton(const JointGraph::Part& part, PartState& state,
                           std::span<const JointRecord> records, const SubstepContext& ctx) {
  if (part.points) {
    if (!state.factored) {
      assemble_points(part, state);
      factor(part);
    }
    evaluate_points(part, records, ctx);
    solve(part);
    gather_points(part);
  } else {
    state.changed = evaluate(part, state, records, ctx);
    if (state.changed || !state.factored) {
      assemble(part);
      factor(part);
    }
    solve(part);
    gather(part);
  }
  state.factored = true;
  ++state.iteration;
  limit_turns(part);
  return move(part, ctx);
}

void JointSystem::prepare(const JointGraph::Part& part, PartState& state,
                          std::span<const JointRecord> records, const SubstepContext& ctx) {
  state.prepared = true;
  state.factored = false;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    const SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    slots_[s].inv_mass = body.inv_mass;
    slots_[s].inv_inertia = slots_[s].inv_own = body.inv_inertia_w;
    slots_[s].dx.setZero();
    slots_[s].dtheta.setZero();
  }
  start_slots(part, state, ctx);
  if (state.channel == Channel::Real) {
    for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
      slots_[s].inertia = slots_[s].inv_inertia;
      block::invert(slots_[s].inertia);
    }
    stiffen(part, ctx);
  }
  if (!part.points) weigh(part, records);
}

void JointSystem::start_slots(const JointGraph::Part& part, const PartState& state,
                              const SubstepContext& ctx) {
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    const SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    slots_[s].sum_dx.setZero();
    slots_[s].sum_dtheta.setZero();
    slots_[s].v = body.v;
    slots_[s].w = state.channel == Channel::Real ? body.w : Vec3(Vec3::Zero());
    slots_[s].q = body.q;
    slots_[s].alone = body.dtheta.isZero(0.0);
    slots_[s].carried = false;
  }
}

void JointSystem::begin_iteration(const JointGraph::Part& part, PartState& state,
                                  const SubstepContext& ctx) {
  state.work += balance(part, ctx, Vec3::Zero()).work;
  state.position_iteration = ctx.iteration;
  state.iteration = 0;
  start_slots(part, state, ctx);
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    nodes_[k].lambda_start = nodes_[k].lambda;
  }
}

void JointSystem::take_gradients(NodeState& node, NodeRows& rows, const JointRecord& record,
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
    const JointTurn turn = JointTurn::of(basis_a.conjugate() * (b.q * def.frame_b.basis));
    rows.dir.rightCols<4>().setZero();
    rows.arm_b.col(kTwist) = axes * turn.twist_gradient();
    rows.arm_b.col(4) = axes * turn.swing_gradient(1);
    rows.arm_b.col(5) = axes * turn.swing_gradient(2);
    rows.arm_b.col(kCone) = axes * turn.u;
    rows.arm_a.rightCols<4>() = rows.arm_b.rightCols<4>();
  }
}

/// Take the gradients anew, from the poses as they are.
void JointSystem::turn_gradients(const JointGraph::Part& part, std::span<const JointRecord> records,
                                 const SubstepContext& ctx) {
  const SolverBody ground;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const std::uint32_t joint = graph_.nodes()[k].joint;
    if (joint == kNone || nodes_[k].off) continue;
    const SixDofJointDef& def = records[joint].def;
    const SolverBody& a = body_of(def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(def.b, ctx.bodies, ground);
    if (part.points) {
      nodes_[k].r_a = rotate(a.q, def.frame_a.anchor);
      nodes_[k].r_b = rotate(b.q, def.frame_b.anchor);
    } else {
      take_gradients(nodes_[k], rows_[k], records[joint], a, b);
    }
  }
}

void JointSystem::weigh(const JointGraph::Part& part, std::span<const JointRecord> records) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    if (plan.joint == kNone || nodes_[k].off) continue;
    NodeRows& rows = rows_[k];
    double inv_mass = 0.0;
    if (plan.slot_a != kNone) inv_mass += slots_[plan.slot_a].inv_mass;
    if (plan.slot_b != kNone) inv_mass += slots_[plan.slot_b].inv_mass;
    for_bits(records[plan.joint].used, [&](int i) {
      double w = inv_mass * rows.dir.col(i).squaredNorm();
      if (plan.slot_a != kNone) {
        rows.b_a.col(i) = slots_[plan.slot_a].inv_inertia * rows.arm_a.col(i);
        w += rows.arm_a.col(i).dot(rows.b_a.col(i));
      }
      if (plan.slot_b != kNone) {
        rows.b_b.col(i) = slots_[plan.slot_b].inv_inertia * rows.arm_b.col(i);
        w += rows.arm_b.col(i).dot(rows.b_b.col(i));
      }
      rows.w[i] = w;
    });
  }
}

bool JointSystem::evaluate(const JointGraph::Part& part, const PartState& state,
                           std::span<const JointRecord> records, const SubstepContext& ctx) {
  bool changed = false;
  const SolverBody ground;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    double* right = &right_[plan.right];
    if (plan.joint == kNone) {
      std::fill_n(right, plan.rows, 0.0);
      continue;
    }
    if (node.off) continue;
    NodeRows& rows = rows_[k];
    const JointRecord& record = records[plan.joint];
    const SolverBody& a = body_of(record.def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(record.def.b, ctx.bodies, ground);
    double c[kCoordinates];
    coordinates(record, a, b, record.twist, c);
    int n = 0;
    for_bits(record.used, [&](int i) {
      Segment segment = rows.law[i].segment(c[i], node.lambda[i], rows.w[i]);
      if (segment.kind != rows.last_kind[i]) ++rows.flips[i];
      const bool stop =
          segment.kind == Segment::Kind::Lower || segment.kind == Segment::Kind::Upper;
      if (stop && rows.flips[i] > kFlips) {
        // It cannot settle with its neighbours: let go, the next substep sees where it stands.
        segment = {Segment::Kind::Force, c[i], 1e9 * rows.w[i], 0.0};
      }
      rows.last_kind[i] = segment.kind;
      if (segment.kind == Segment::Kind::None) return;
      changed = changed || n >= node.n || rows.coordinate[n] != i || rows.kind[n] != segment.kind;
      rows.coordinate[n] = static_cast<std::uint8_t>(i);
      rows.kind[n] = segment.kind;
      node.at[n] = part.regular ? segment.at : std::max(segment.at, state.redundancy * rows.w[i]);
      right[n] = -(c[i] - segment.target) - node.at[n] * (node.lambda[i] - segment.offset);
      ++n;
    });
    changed = changed || n != node.n;
    node.n = n;
  }
  return changed;
}

/// Turn the body by slot.dtheta. Where it spins about another axis the correction is an impulse at
/// the start of the substep, from where it turns freely with its new angular momentum: turning it
/// afterwards is right to first order in w h only, and costs a fast top its spin.
void JointSystem::turn(SolverBody& body, Slot& slot, double h) {
  if (slot.alone && !slot.carried &&
      h * h * slot.w.cross(slot.dtheta).squaredNorm() > kNoTurn * kNoTurn) {
    slot.carried = body.inv_inertia_w.determinant() > 0.0;  // no axis is locked
  }
  if (!slot.carried) {
    body.q = rotated_about(body.q, slot.dtheta);
    return;
  }
  const Mat3 axes = slot.q.toRotationMatrix();
  const Mat3 inertia_l = axes.transpose() * body.inv_inertia_w.inverse() * axes;
  const Vec3 spin_l = axes.transpose() * (slot.w + body.dtheta / h);
  const Vec3 momentum_w = axes * (inertia_l * spin_l);
  Vec3 w_l = inertia_l.inverse() * (slot.q_start.conjugate() * momentum_w);
  body.q = free_rotation(slot.q_start, inertia_l, w_l, h);
}

void JointSystem::gather(const JointGraph::Part& part) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    if (plan.joint == kNone || node.n == 0) continue;
    const NodeRows& rows = rows_[k];
    const double* dlambda = &right_[plan.right];
    Vec3 p = Vec3::Zero();
    Vec3 turn_a = Vec3::Zero();
    Vec3 turn_b = Vec3::Zero();
    for (int r = 0; r < node.n; ++r) {
      const int i = rows.coordinate[r];
      node.lambda[i] += dlambda[r];
      p += dlambda[r] * rows.dir.col(i);
      if (plan.slot_a != kNone) turn_a += dlambda[r] * rows.b_a.col(i);
      if (plan.slot_b != kNone) turn_b += dlambda[r] * rows.b_b.col(i);
    }
    if (plan.slot_a != kNone) {
      Slot& slot = slots_[plan.slot_a];
      slot.dx -= slot.inv_mass * p;
      slot.dtheta -= turn_a;
    }
    if (plan.slot_b != kNone) {
      Slot& slot = slots_[plan.slot_b];
      slot.dx += slot.inv_mass * p;
      slot.dtheta += turn_b;
    }
  }
}

/// A turn that no gradient reaches is taken in parts.
void JointSystem::limit_turns(const JointGraph::Part& part) {
  double turn2 = 0.0;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    turn2 = std::max(turn2, slots_[s].dtheta.squaredNorm());
  }
  if (!(turn2 > kTrust * kTrust)) return;
  const double share = kTrust / std::sqrt(turn2);
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    slots_[s].dx *= share;
    slots_[s].dtheta *= share;
  }
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    NodeState& node = nodes_[k];
    if (graph_.nodes()[k].joint == kNone) continue;
    const double* dlambda = &right_[graph_.nodes()[k].right];
    for (int r = 0; r < node.n; ++r) {
      node.lambda[part.points ? r : rows_[k].coordinate[r]] -= (1.0 - share) * dlambda[r];
    }
  }
}

double JointSystem::move(const JointGraph::Part& part, const SubstepContext& ctx) {
  double largest = 0.0;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    Slot& slot = slots_[s];
    SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    body.x += slot.dx;
    body.dx += slot.dx;
    slot.sum_dx += slot.dx;
    slot.sum_dtheta += slot.dtheta;
    body.dtheta += slot.dtheta;
    turn(body, slot, ctx.h);
    largest = std::max({largest, slot.dx.squaredNorm(), slot.dtheta.squaredNorm()});
    slot.dx.setZero();
    slot.dtheta.setZero();
  }
  return std::sqrt(largest);
}

}  // namespace tandem::pbd
