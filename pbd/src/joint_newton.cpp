// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_newton.h"

#include "free_rotation.h"
#include "integrate.h"
#include "joint_factor.h"
#include "joint_points.h"
#include "joint_six_dof.h"
#include "joint_stability.h"

namespace tandem::pbd {
namespace {

/// Loops that add energy are solved again with this factor of more compliance, at most so often.
constexpr double kSofter = 100.0;
constexpr int kSoften = 2;
/// Moves that shrink less than this per iteration need a better matrix.
constexpr double kSlow = 0.3;
/// m; smaller moves are mostly rounding.
constexpr double kFine = 1e-7;
/// Share of the tolerance. At the default 60 um/s^2 are left of a substep's load: a net of 30 x 30
/// balls at rest takes 0.4 of the time and moves by 1e-9 m. A hundred times as much keeps it
/// moving.
constexpr double kSettled = 2e-4;
/// m/s; faster nets are not tested for this, which costs a tenth of a solve. One of 30 x 30 balls
/// that comes to rest is as cheap with it.
constexpr double kSlowNet = 0.1;
/// rad; trust region: bodies turn no further in one iteration.
constexpr double kTrust = 0.5;
/// While a gap closes, bodies are this much easier to shift than to turn, relative to their
/// inertia. Otherwise bodies that hang on an anchor placed 10 m to the side are dragged along, and
/// swing at 11 rad/s at the end.
constexpr double kClosingTurn = 1e-3;
/// Share of the tolerance, taken in rad: a turn whose series ends with a smaller term needs no free
/// rotation, which takes as long as the rest of an iteration: dolls on the ground take 0.8 of the
/// time. At 1e-4 a top of 5 rad/s changes its spin by 3e-5 in 30 s at 240 Hz, now by 6e-8.
constexpr double kCurve = 1e-5;

/// Remaining distance of moves that shrink geometrically, as with a constant matrix.
double rest_of(double move, double before) {
  const double rate = move / before;
  return rate < kSlow ? move * rate / (1.0 - rate) : move;
}

void take_gradients(const JointPart& part) {
  if (part.plan.points) {
    joint_points::take_gradients(part);
  } else {
    joint_six_dof::take_gradients(part);
  }
}

void weigh(const JointPart& part) {
  if (part.plan.points) {
    joint_points::weigh(part);
  } else {
    joint_six_dof::weigh(part);
  }
}

void start_bodies(const JointPart& part) {
  part.for_bodies([&](JointSlot& slot, const SolverBody& body) {
    slot.sum.dx.setZero();
    slot.sum.dtheta.setZero();
    slot.v = body.v;
    slot.w = part.progress.channel == JointChannel::Real ? body.w : Vec3(Vec3::Zero());
    slot.before = {body.x, body.q, {body.dx, body.dtheta}};
    slot.alone = body.dtheta.isZero(0.0) && body.inv_inertia_w.determinant() > 0.0;
  });
}

void prepare(const JointPart& part) {
  part.progress.prepared = true;
  part.progress.position_iteration = part.ctx.iteration;
  part.progress.factored = false;
  const double ease = part.progress.closing ? kClosingTurn : 1.0;
  part.for_bodies([&](JointSlot& slot, const SolverBody& body) {
    slot.inv_mass = body.inv_mass;
    slot.inv_own = body.inv_inertia_w;
    slot.inv_inertia = ease * body.inv_inertia_w;
    slot.dx.setZero();
    slot.dtheta.setZero();
  });
  start_bodies(part);
  if (part.progress.channel == JointChannel::Real) {
    part.for_bodies([](JointSlot& slot, const SolverBody&) {
      slot.inertia = slot.inv_inertia;
      block::invert(slot.inertia);
    });
    stiffen(part);
  }
  weigh(part);
}

/// Contacts have been solved since: energy is counted, and the solve restarted, from here.
void begin_iteration(const JointPart& part) {
  part.progress.work += work_of(part);
  part.progress.position_iteration = part.ctx.iteration;
  part.progress.iteration = 0;
  start_bodies(part);
  part.for_nodes([](std::uint32_t, const JointGraph::Node&, JointNode& node) {
    node.lambda_start = node.lambda;
  });
}

/// What the free rotation after an impulse adds to its own turn, to first order in the spin: with
/// a change dL of the angular momentum L the turn f ends as df/dt = I^-1 (dL - f x L) has it.
Vec3 bend_of(const JointSlot& slot, const Vec3& w, double h) {
  const Vec3& turn = slot.dtheta;
  const Vec3 change = block::times(slot.inertia, turn);
  const Vec3 momentum = block::times(slot.inertia, w);
  const Vec3 torque = w.cross(change) + momentum.cross(turn);
  return 0.5 * h * (turn.cross(w) + block::times(slot.inv_own, torque));
}

/// Turns the body by slot.dtheta. If it spins, the correction is an impulse at the start of the
/// substep, followed by free rotation with the new angular momentum. Turning it afterwards is right
/// only to first order in w h, and costs a fast top its spin.
void turn(SolverBody& body, JointSlot& slot, const SubstepContext& ctx) {
  const double h = ctx.h;
  Vec3 bend = Vec3::Zero();
  if (slot.alone && !slot.w.isZero(0.0))
    bend = bend_of(slot, slot.w + (body.dtheta - 0.5 * slot.dtheta) / h, h);
  // The next term is about as much smaller again.
  if (bend.squaredNorm() <= kCurve * ctx.joint_tolerance * slot.dtheta.norm()) {
    body.q = rotated_about(body.q, slot.dtheta + bend);
    return;
  }
  const Mat3 axes = slot.before.q.toRotationMatrix();
  LocalInertia& local = slot.local;
  if (local.inertia.isZero(0.0)) {
    local.inverse = axes.transpose() * body.inv_inertia_w * axes;
    local.inertia = local.inverse.inverse();
    local.principal = principal_axes(local.inertia);
  }
  const Vec3 spin_l = axes.transpose() * (slot.w + body.dtheta / h);
  const Vec3 momentum_w = axes * (local.inertia * spin_l);
  Vec3 w_l = local.inverse * (slot.q_start.conjugate() * momentum_w);
  body.q = free_rotation(slot.q_start, local.principal, w_l, h);
}

/// Scales large turns to the trust region, since gradients do not reach that far.
/// @return whether it did
bool limit_turns(const JointPart& part) {
  double turn2 = 0.0;
  part.for_bodies([&](const JointSlot& slot, const SolverBody&) {
    turn2 = std::max(turn2, slot.dtheta.squaredNorm());
  });
  if (!(turn2 > kTrust * kTrust)) return false;
  const double share = kTrust / std::sqrt(turn2);
  part.for_bodies([&](JointSlot& slot, const SolverBody&) {
    slot.dx *= share;
    slot.dtheta *= share;
  });
  part.for_nodes([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    if (plan.joint == JointGraph::kNone) return;
    const double* dlambda = &part.all.right[plan.right];
    for (int r = 0; r < node.n; ++r) {
      node.lambda[part.plan.points ? r : part.all.rows[k].coordinate[r]] -=
          (1.0 - share) * dlambda[r];
    }
  });
  return true;
}

/// @return the largest move of a body, m or rad
double move_bodies(const JointPart& part) {
  double largest = 0.0;
  part.for_bodies([&](JointSlot& slot, SolverBody& body) {
    body.x += slot.dx;
    body.dx += slot.dx;
    slot.sum.dx += slot.dx;
    slot.sum.dtheta += slot.dtheta;
    body.dtheta += slot.dtheta;
    turn(body, slot, part.ctx);
    largest = std::max({largest, slot.dx.squaredNorm(), slot.dtheta.squaredNorm()});
    slot.dx.setZero();
    slot.dtheta.setZero();
  });
  return std::sqrt(largest);
}

/// Whether every row is within a small share of the tolerance.
bool is_settled(const JointPart& part) {
  joint_points::evaluate(part);
  double most = 0.0;
  part.for_joints([&](std::uint32_t, const JointGraph::Node& plan, const JointNode& node) {
    const double* left = &part.all.right[plan.right];
    for (int r = 0; r < node.n; ++r) most = std::max(most, std::abs(left[r]));
  });
  return most <= kSettled * part.ctx.joint_tolerance;
}

/// Whether the bodies of a part are slow, apart from the velocity that gravity adds in this
/// substep.
bool is_slow(const JointPart& part) {
  bool slow = true;
  part.for_bodies([&](const JointSlot&, const SolverBody& body) {
    const Vec3 fall = part.ctx.h * body.gravity_scale * part.ctx.gravity;
    slow = slow && (body.v - fall).squaredNorm() <= kSlowNet * kSlowNet;
  });
  return slow;
}

/// Warm start: before the first iteration bodies move by the forces of the last substep. Loops keep
/// only those of brakes: the load that redundant rows share has no effect until the bodies turn,
/// and in a slider-crank it then grows a hundredfold per substep. Nets, whose matrix costs most,
/// end here if nothing else has to move.
/// @return whether nothing has
bool start(const JointPart& part) {
  prepare(part);
  const bool net = part.plan.points && !part.plan.regular;
  if (net && !is_slow(part)) return false;
  if (part.plan.points) {
    joint_points::warm_start(part);
  } else {
    joint_six_dof::warm_start(part, !part.plan.regular);
  }
  limit_turns(part);
  move_bodies(part);
  if (!net) return false;
  if (is_settled(part)) return true;
  restart(part, false);
  prepare(part);
  return false;
}

/// For rows of several kinds: a multiplier that reaches a corner of its law stays there. The next
/// iteration finds which ones leave it again.
double newton_by_pieces(const JointPart& part) {
  JointProgress& progress = part.progress;
  progress.changed = joint_six_dof::evaluate(part) || progress.left_pieces;
  progress.pinned = progress.left_pieces = false;
  double largest = 0.0;
  for (bool done = false; !done;) {
    if (progress.changed || !progress.factored) {
      joint_six_dof::assemble(part);
      factor(part);
    }
    progress.factored = true;
    solve(part);
    const bool whole = joint_six_dof::gather(part);
    done = limit_turns(part) || whole;
    largest = std::max(largest, move_bodies(part));
    if (whole) break;
    progress.changed = progress.pinned = true;
    joint_six_dof::pin(part);
  }
  return largest;
}

double newton(const JointPart& part) {
  JointProgress& progress = part.progress;
  ++progress.iteration;
  if (!part.plan.points) return newton_by_pieces(part);
  if (!progress.factored) {
    joint_points::assemble(part);
    factor(part);
  }
  progress.factored = true;
  joint_points::evaluate(part);
  solve(part);
  joint_points::gather(part);
  limit_turns(part);
  return move_bodies(part);
}

/// Whether a part that was converged still is: no other rows have moved its bodies since.
bool still_holds(const JointPart& part) {
  bool same = part.progress.holds;
  if (!same) return false;
  part.for_bodies([&](const JointSlot& slot, const SolverBody& body) {
    same = same && body.dx == slot.seen.dx && body.dtheta == slot.seen.dtheta;
  });
  return same;
}

/// Whether the first iteration has moved a row to another piece of its law, for example onto a
/// limit that gravity alone did not reach. Later iterations find that when they begin.
bool leaves_pieces(const JointPart& part) {
  JointProgress& progress = part.progress;
  if (part.plan.points || progress.iteration > 1) return false;
  progress.left_pieces = joint_six_dof::evaluate(part);
  return progress.left_pieces;
}

void note_whether_it_holds(const JointPart& part, double left) {
  part.progress.holds = left <= part.ctx.joint_tolerance;
  if (!part.progress.holds) return;
  part.for_bodies([](JointSlot& slot, const SolverBody& body) {
    slot.seen = {body.dx, body.dtheta};
  });
}

double iterate(const JointPart& part) {
  JointProgress& progress = part.progress;
  if (progress.channel == JointChannel::Displacement) {
    // Bodies move as far as their targets, so each iteration takes new gradients; the final
    // clean-up uses the bodies' own masses again.
    take_gradients(part);
    prepare(part);
    return newton(part);
  }
  if (!progress.prepared) {
    if (start(part)) return 0.0;
  } else if (progress.position_iteration != part.ctx.iteration) {
    begin_iteration(part);
  }
  const double before = progress.last_move;
  progress.last_move = newton(part);
  const auto is_slow = [&] {
    return progress.iteration > 1 && !progress.changed && progress.last_move > kSlow * before &&
           progress.last_move > kFine;
  };
  const auto start_anew = [&](bool learn) {
    restart(part, learn);
    progress.iteration = 0;
    prepare(part);
    progress.last_move = newton(part);
  };
  const bool may_soften = !part.plan.regular && part.passive && progress.softened < kSoften;
  if (may_soften && adds_energy(part)) {
    ++progress.softened;
    progress.redundancy *= kSofter;
    start_anew(false);
  } else if (!progress.linear && stops_add_energy(part)) {
    progress.linear = true;
    start_anew(false);
  } else if (is_slow() && !progress.restarted) {
    progress.restarted = true;
    start_anew(true);
  } else if (is_slow()) {
    take_gradients(part);
    weigh(part);
    progress.factored = false;
  }
  if (progress.pinned) return std::max(progress.last_move, kTrust);  // pins may come off
  return progress.iteration > 1 && !progress.changed ? rest_of(progress.last_move, before)
                                                     : progress.last_move;
}

}  // namespace

double newton_iteration(const JointPart& part) {
  const bool same_turn = part.progress.position_iteration == part.ctx.iteration;
  if (same_turn && still_holds(part)) return 0.0;
  double left = iterate(part);
  if (left <= part.ctx.joint_tolerance && leaves_pieces(part)) left = kTrust;
  note_whether_it_holds(part, left);
  return part.progress.holds ? 0.0 : left;
}

}  // namespace tandem::pbd
