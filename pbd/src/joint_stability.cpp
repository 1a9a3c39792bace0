// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_stability.h"

#include "integrate.h"
#include "joint_six_dof.h"

namespace tandem::pbd {
namespace {

/// Share of the geometric stiffness that is added to inertia if the substep does not resolve it:
/// from 1/4 on, any rate is stable (Newmark's average acceleration).
constexpr double kStiffShare = 0.3;
/// Share of it that damps neighbours that turn against each other.
constexpr double kStiffDamping = 0.1;
/// Both are blended in over this range of (rate h)^2; leapfrog is stable below 4.
constexpr double kStiffFrom = 2.0;
constexpr double kStiffTo = 8.0;
/// Share of a part's kinetic energy that its joints may add before it is removed.
constexpr double kSurplus = 0.01;
/// Share that one substep of loops may add before they are solved again, softer.
constexpr double kMaxAdded = 0.1;
/// Share that joints at limits may add before limits are linearised.
constexpr double kStopSurplus = 1e-4;
/// Share that rounding may change between joint solves.
constexpr double kUndisturbed = 1e-9;
/// Largest share given back in one substep.
constexpr double kMaxGiven = 1.0;

void apply_stiffness(JointSlot& slot, SolverBody& body) {
  for (int i = 0; i < 3; ++i) {
    if (slot.inv_inertia(i, i) > 0.0) continue;  // a locked axis
    slot.stiffness.row(i).setZero();
    slot.stiffness.col(i).setZero();
  }
  slot.inv_inertia = slot.inertia + (kStiffShare + kStiffDamping) * slot.stiffness;
  block::invert(slot.inv_inertia);
  const Vec3 dtheta = block::times(slot.inv_inertia, slot.dtheta);
  body.q = rotated_about(body.q, dtheta);
  body.dtheta += dtheta;
  slot.sum.dtheta += dtheta;
  slot.stiffness.setZero();
}

/// Whether a part has limits or brakes.
bool takes_energy(const JointPart& part) {
  bool takes = false;
  if (part.plan.points) return false;
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, const JointNode&) {
    const JointRows& rows = part.all.rows[k];
    takes = takes || rows.stops != 0;
    for_bits(part.records[plan.joint].used, [&](int i) {
      takes = takes || rows.law[i].motor_max > 0.0 || rows.law[i].servo_k > 0.0;
    });
  });
  return takes;
}

/// Whether lost energy of a part may be given back: it has no inelastic stops.
bool is_ideal(const JointPart& part) {
  bool held = false;
  part.for_joints([&](std::uint32_t, const JointGraph::Node& plan, const JointNode&) {
    held = held || plan.slot_a == JointGraph::kNone || plan.slot_b == JointGraph::kNone;
  });
  return held && !takes_energy(part);
}

/// Energy balance of a part in a substep, J.
struct Balance {
  double work = 0.0;       ///< by joints, in this position iteration
  double energy = 0.0;     ///< before, relative to the mean motion
  double disturbed = 0.0;  ///< by others since joints were solved
};

Balance balance(const JointPart& part, const Vec3& mean) {
  Balance sum;
  const double rate = 1.0 / part.ctx.h;
  part.for_bodies([&](const JointSlot& slot, const SolverBody& body) {
    const Vec3 dv = rate * slot.sum.dx;
    const Vec3 dw = rate * slot.sum.dtheta;
    const Mat3& inertia = slot.inertia;
    // The inertia turns with the body, the angular momentum does not.
    const Vec3 start = block::times(inertia, slot.w);
    const Vec3 momentum = start + block::times(inertia, dw);
    const Vec3 momentum_l = exp_map(-slot.sum.dtheta) * momentum;
    const double own = 1.0 / body.inv_mass;
    sum.work += own * dv.dot(slot.v + 0.5 * dv) +
                0.5 * (momentum_l.dot(block::times(slot.inv_own, momentum_l)) - slot.w.dot(start));
    sum.energy +=
        0.5 * (own * (body.v - mean).squaredNorm() + body.w.dot(block::times(inertia, body.w)));
    if (part.plan.regular) return;
    // Joints receive half of the velocity that other forces have added: poses lie between two
    // velocities.
    sum.work -=
        0.5 * own * dv.dot(slot.v - slot.start.v) + 0.5 * dw.dot(start - slot.start.momentum);
    sum.disturbed += 0.5 * own * (body.v - slot.v - dv).squaredNorm();
  });
  return sum;
}

}  // namespace

void restart(const JointPart& part, bool learn) {
  part.for_bodies([](const JointSlot& slot, SolverBody& body) {
    body.x = slot.before.x;
    body.q = slot.before.q;
    body.dx = slot.before.move.dx;
    body.dtheta = slot.before.move.dtheta;
  });
  part.for_joints([&](std::uint32_t k, const JointGraph::Node& plan, JointNode& node) {
    if (learn) node.add_pull(plan, part.impulse(k, part.records[plan.joint].used));
    node.lambda = node.lambda_start;
  });
}

/// A projection never adds kinetic energy. If the corrections of a loop do, its rows are nearly
/// redundant and ask for moves far larger than their violation.
bool adds_energy(const JointPart& part) {
  double before = 0.0;  // J, twice
  double after = 0.0;
  const double rate = 1.0 / part.ctx.h;
  part.for_bodies([&](const JointSlot& slot, const SolverBody& body) {
    const Vec3 v = slot.v + rate * slot.sum.dx;
    const Vec3 w = slot.w + rate * slot.sum.dtheta;
    before += slot.v.squaredNorm() / body.inv_mass + slot.w.dot(slot.inertia * slot.w);
    after += v.squaredNorm() / body.inv_mass + w.dot(slot.inertia * w);
  });
  return after > (1.0 + kMaxAdded) * before;
}

/// At limits met by bodies that turn far within the substep, such as a light link between heavy
/// ones, the gradient of the start may need a large impulse to satisfy the limit at the end.
bool stops_add_energy(const JointPart& part) {
  if (part.progress.iteration < 2 || !takes_energy(part)) return false;
  const Balance sum = balance(part, Vec3::Zero());
  return sum.work > kStopSurplus * sum.energy &&
         sum.work - joint_six_dof::supplied(part) > kStopSurplus * sum.energy;
}

/// Part of a body's geometric stiffness from its joint forces: a taut link is turned back at a rate
/// that the substep may not resolve. With the stiffness at the end of the substep weighted by at
/// least 1/4, any rate is stable and slow turning is not damped (Newmark's average acceleration).
/// As the change of a lever arm against uniform turning is due to the correction, the share adds to
/// inertia: (I + share K) dtheta = r x lambda.
void stiffen(const JointPart& part) {
  std::vector<JointSlot>& slots = part.all.slots;
  // dx and dtheta are unused before the first iteration: dx.x holds the body's (rate h)^2.
  const auto rate = [&](std::uint32_t s, const Vec3& r, double pull) {
    if (pull <= 0.0) return;
    const Mat3& inv = slots[s].inv_inertia;
    slots[s].dx.x() += pull * (inv.trace() - r.dot(block::times(inv, r)) / r.squaredNorm());
  };
  part.for_joints([&](std::uint32_t, const JointGraph::Node& plan, const JointNode& node) {
    rate(plan.slot_a, node.r_a, node.pull_a);
    rate(plan.slot_b, node.r_b, node.pull_b);
  });
  double largest = 0.0;
  part.for_bodies(
      [&](const JointSlot& slot, const SolverBody&) { largest = std::max(largest, slot.dx.x()); });
  if (largest > kStiffFrom) {
    const auto share = [&](std::uint32_t s) {
      constexpr double kPerRate = 1.0 / (kStiffTo - kStiffFrom);
      return std::clamp(kPerRate * (slots[s].dx.x() - kStiffFrom), 0.0, 1.0);
    };
    const auto add = [&](std::uint32_t s, const Vec3& r, double pull, const Vec3& turn) {
      const double k = pull > 0.0 ? share(s) * pull : 0.0;
      if (k == 0.0) return;
      const Vec3 kr = (k / r.squaredNorm()) * r;
      JointSlot& slot = slots[s];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          const double before = slot.stiffness(j, i);
          slot.stiffness(j, i) = (i == j ? before + k : before) - r[i] * kr[j];
        }
      }
      // There is no stiffness about the link itself.
      slot.dtheta += kStiffDamping * (k * turn - r.dot(turn) * kr);
    };
    part.for_joints([&](std::uint32_t, const JointGraph::Node& plan, const JointNode& node) {
      // Damps neighbours that turn against each other at an unresolved rate.
      Vec3 turn = Vec3::Zero();
      if (plan.slot_a != JointGraph::kNone && plan.slot_b != JointGraph::kNone) {
        turn = part.ctx.h * (slots[plan.slot_b].w - slots[plan.slot_a].w);
      }
      add(plan.slot_a, node.r_a, node.pull_a, turn);
      add(plan.slot_b, node.r_b, node.pull_b, -turn);
    });
  }
  part.for_bodies([](JointSlot& slot, SolverBody& body) {
    if (slot.dx.x() > kStiffFrom) apply_stiffness(slot, body);
    slot.dx.setZero();
    slot.dtheta.setZero();
  });
}

namespace {

/// m/s, of the part's centre of mass.
Vec3 mean_velocity(const JointPart& part) {
  double mass = 0.0;
  Vec3 mean = Vec3::Zero();
  part.for_bodies([&](const JointSlot&, const SolverBody& body) {
    const double own = 1.0 / body.inv_mass;
    mass += own;
    mean += own * body.v;
  });
  return mean / mass;
}

/// Removes `excess` (J) from the motion of the part relative to its mean, which has `energy` (J).
void take(const JointPart& part, double excess, double energy, const Vec3& mean) {
  const double scale = std::sqrt(std::max(0.0, 1.0 - excess / energy));
  part.for_bodies([&](const JointSlot&, SolverBody& body) {
    body.v = mean + scale * (body.v - mean);
    body.w *= scale;
  });
}

}  // namespace

double work_of(const JointPart& part) { return balance(part, Vec3::Zero()).work; }

/// Rigid locks and limits do no work. If they did, because bodies turned further within a substep
/// than gradients reach, the excess is removed from the motion of the part relative to its mean:
/// unresolved motion may shake, but does not grow.
///
/// Loops lose energy as well. Where rows are redundant to first order only, as in a lattice
/// stretched flat, a motion that no gradient shows ends within a substep: an impact, at any substep
/// length. Ideal locks do not take that energy, so it is given back, except for what contacts may
/// still lose. A free-floating part conserves its angular momentum instead.
void limit_energy_gain(const JointPart& part) {
  const Vec3 mean = mean_velocity(part);
  const auto [done, energy, disturbed] = balance(part, mean);
  double work = part.progress.work + done;
  const JointGraph& graph = part.all.graph;
  const auto joint_after = [&](std::uint32_t k) {
    while (graph.nodes()[k].joint == JointGraph::kNone) ++k;
    return k;
  };
  const std::uint32_t first = joint_after(part.plan.node);
  double& owed = part.records[graph.nodes()[first].joint].energy_excess;
  const double room = kSurplus * energy;
  double least = -room;
  if (!part.plan.regular) {
    // The impact of contacts on one body is shared by the joints next: they may lose that much at
    // most.
    double& shared = part.records[graph.nodes()[joint_after(first + 1)].joint].energy_excess;
    const double lost = std::clamp(-work, 0.0, shared);
    work += lost;
    shared = 0.5 * (shared - lost);
    if (disturbed > kUndisturbed * energy) {
      shared += disturbed;
    } else if (is_ideal(part)) {
      least -= kMaxGiven * energy;
    }
  }
  owed = std::max(owed + work, least);
  const double kept = std::clamp(owed, -room, room);
  const double excess = owed - kept;
  owed = kept;
  if (!(std::abs(excess) > 0.0)) return;
  take(part, excess, energy, mean);
}

/// If bodies turn too far for their gradients, joints add energy in each alternation, and contacts
/// pass it on: a body falling on its end gained a factor of 7 per alternation.
void limit_turn(const JointPart& part) {
  const Vec3 mean = mean_velocity(part);
  double work = part.progress.work;
  double energy = 0.0;  // J, relative to the mean
  part.for_bodies([&](const JointSlot& slot, const SolverBody& body) {
    const double own = 1.0 / body.inv_mass;
    const Vec3 w =
        (slot.before.q * body.q.conjugate()) * body.w;  // the inertia turns with the body
    const double spin = w.dot(block::times(slot.inertia, w));
    energy += 0.5 * (own * (body.v - mean).squaredNorm() + spin);
    work += 0.5 * (own * (body.v.squaredNorm() - slot.v.squaredNorm()) + spin -
                   slot.w.dot(block::times(slot.inertia, slot.w)));
  });
  const double room = kSurplus * energy;
  if (!(work > room)) return;
  take(part, work - room, energy, mean);
  part.progress.work = room - work_of(part);
}

}  // namespace tandem::pbd
