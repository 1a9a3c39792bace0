// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_system.h"

#include <bit>

namespace tandem::pbd {
namespace {

constexpr std::uint32_t kNone = JointGraph::kNone;
/// Rows that may repeat each other share their load as if they had this much compliance, relative
/// to their own mobility. A rope of 50 links held at both ends sags by less than 1e-8 m from it.
constexpr double kRedundancy = 1e-9;
/// Part of the geometric stiffness that is added to inertia where the substep does not resolve it:
/// from 1/4 on no rate is too high (the average acceleration method of Newmark).
constexpr double kStiffShare = 0.3;
/// How much of it brakes neighbours that turn against each other.
constexpr double kStiffDamping = 0.1;
/// Both come in over this range of (rate h)^2; leapfrog is stable below 4.
constexpr double kStiffFrom = 2.0;
constexpr double kStiffTo = 8.0;
/// Moves that shrink less than this from iteration to iteration call for a better matrix.
constexpr double kSlow = 0.3;
/// m; smaller moves are rounding as like as not.
constexpr double kFine = 1e-7;
/// rad; bodies turn no further in one iteration.
constexpr double kTrust = 0.5;
/// How often a limit may come and go within a substep.
constexpr int kFlips = 6;
/// Part of a part's kinetic energy that its joints may have given it before it is taken back.
constexpr double kSurplus = 0.01;

const SolverBody& body_of(BodyId id, std::span<const SolverBody> bodies, const SolverBody& ground) {
  return id.valid() ? bodies[id.index] : ground;
}

std::uint32_t movable(BodyId id, std::span<const SolverBody> bodies) {
  return id.valid() && bodies[id.index].inv_mass > 0.0 ? id.index : kNone;
}

template <class Visit>
void for_bits(std::uint32_t bits, Visit&& visit) {
  for (; bits != 0; bits &= bits - 1) visit(std::countr_zero(bits));
}

}  // namespace

JointAxis JointRecord::axis(int c) const {
  if (c < 3) return def.linear[static_cast<std::size_t>(c)];
  if (c < kCone) return def.angular[static_cast<std::size_t>(c - 3)];
  JointAxis cone;
  if (def.cone < kUnlimited) cone.freedom = Freedom::Limited;
  cone.lower = -kUnlimited;
  cone.upper = def.cone;
  cone.compliance = def.cone_compliance;
  return cone;
}

bool JointRecord::passive() const {
  for (int c = 0; c < kCoordinates; ++c) {
    const JointAxis a = axis(c);
    if (a.compliance > 0.0 || a.motor.mode != MotorMode::Off || a.spring.stiffness > 0.0) {
      return false;
    }
  }
  return true;
}

void JointRecord::refresh() {
  used = 0;
  for (int c = 0; c < kCoordinates; ++c) {
    const JointAxis a = axis(c);
    if (a.freedom != Freedom::Free || a.motor.mode != MotorMode::Off || a.spring.stiffness > 0.0 ||
        a.spring.damping > 0.0) {
      used |= 1u << c;
    }
  }
  point = true;
  for (const JointAxis& a : def.linear) {
    point = point && a.freedom == Freedom::Locked && a.compliance == def.linear[0].compliance &&
            a.damping == def.linear[0].damping;
  }
}

void coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b, double near,
                 double* c) {
  const SixDofJointDef& def = record.def;
  const JointPlace place = JointPlace::of(def, a, b);
  if (record.point) {
    Eigen::Map<Vec3>{c} = place.d;
    if ((record.used >> 3) == 0) return;
  }
  const Quat basis_a = a.q * def.frame_a.basis;
  if (!record.point) Eigen::Map<Vec3>{c} = basis_a.conjugate() * place.d;
  const JointTurn turn = JointTurn::of(basis_a.conjugate() * (b.q * def.frame_b.basis));
  c[kTwist] =
      def.angular[0].freedom == Freedom::Locked ? turn.twist : nearest_turn(turn.twist, near);
  c[4] = turn.swing(1);
  c[5] = turn.swing(2);
  c[kCone] = turn.phi;
}

void JointSystem::build(std::span<const JointRecord> records, std::span<const SolverBody> bodies,
                        const BodyOrder& order) {
  std::vector<JointGraph::Edge> edges;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const JointRecord& r = records[i];
    if (!r.active() || r.used == 0) continue;
    // Known to the graph by their places in the order.
    edges.push_back({static_cast<std::uint32_t>(i), order.rank(movable(r.def.a, bodies)),
                     order.rank(movable(r.def.b, bodies)), r.rows()});
  }
  if (!order.natural()) {
    std::sort(edges.begin(), edges.end(), [&](const auto& l, const auto& r) {
      return order.row_before(records[l.joint].def.a, records[l.joint].def.b, l.joint,
                              records[r.joint].def.a, records[r.joint].def.b, r.joint);
    });
  }
  graph_.build(edges);
  graph_.rename_bodies([&](std::uint32_t rank) { return order.slot(rank); });
  nodes_.assign(graph_.nodes().size(), {});
  slots_.assign(graph_.bodies().size(), {});
  state_.assign(graph_.parts().size(), {});
  order_.assign(graph_.parts().size(), {});
  primary_.assign(graph_.bodies().size(), 0);
  std::vector<std::uint8_t> seen(bodies.size(), 0);
  for (std::size_t s = 0; s < primary_.size(); ++s) {
    std::uint8_t& before = seen[graph_.bodies()[s]];
    primary_[s] = before == 0 ? 1 : 0;
    before = 1;
  }
  passive_.assign(graph_.parts().size(), 1);
  for (std::size_t p = 0; p < passive_.size(); ++p) {
    const JointGraph::Part& part = graph_.parts()[p];
    for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
      const std::uint32_t joint = graph_.nodes()[k].joint;
      if (joint != kNone && !records[joint].passive()) passive_[p] = 0;
    }
  }
  values_.assign(graph_.value_count(), 0.0);
  right_.assign(graph_.right_count(), 0.0);
}

bool JointSystem::fits(std::span<const JointRecord> records,
                       std::span<const SolverBody> bodies) const {
  for (const JointGraph::Node& node : graph_.nodes()) {
    if (node.joint == kNone) continue;
    if (!records[node.joint].active()) return false;  // it broke
    const SixDofJointDef& def = records[node.joint].def;
    if ((movable(def.a, bodies) == kNone) != (node.slot_a == kNone)) return false;
    if ((movable(def.b, bodies) == kNone) != (node.slot_b == kNone)) return false;
  }
  return true;
}

void JointSystem::sort_groups(std::span<const SolverBody> bodies) {
  for (std::uint32_t p = 0; p < part_count(); ++p) {
    order_[p] = {bodies[graph_.bodies()[graph_.parts()[p].body]].group, p};
  }
  std::sort(order_.begin(), order_.end(), [](const GroupPart& x, const GroupPart& y) {
    return x.group != y.group ? x.group < y.group : x.part < y.part;
  });
}

bool JointSystem::is_total(std::uint32_t p, std::span<const SolverBody> bodies) const {
  const JointGraph::Part& part = graph_.parts()[p];
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    if (bodies[graph_.bodies()[s]].total) return true;
  }
  return false;
}

void JointSystem::begin(std::uint32_t p, std::span<JointRecord> records, const SubstepContext& ctx,
                        Channel channel) {
  const JointGraph::Part& part = graph_.parts()[p];
  state_[p] = {.channel = channel};
  const SolverBody ground;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    node.n = 0;
    if (plan.joint == kNone) {
      node.n = plan.rows;
      continue;
    }
    JointRecord& record = records[plan.joint];
    node.off = !record.active();
    if (node.off) continue;
    const SixDofJointDef& def = record.def;
    const SolverBody& a = body_of(def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(def.b, ctx.bodies, ground);
    if (channel == Channel::Real && !a.total && !b.total) {
      for (double& gap : record.gap) gap *= kGapDecay;
    }
    node.lambda.fill(0.0);
    node.last_kind.fill(Segment::Kind::None);
    node.flips.fill(0);
    node.simple = record.point && record.used == 7u;
    double c[kCoordinates];
    coordinates(record, a, b, record.twist, c);
    if ((record.used >> kTwist & 1u) != 0 && channel == Channel::Real) record.twist = c[kTwist];
    take_gradients(node, record, a, b);
    node.pull_a = node.pull_b = 0.0;
    add_pull(plan, node, ctx.h * ctx.h * record.state.force);
    // Force laws.
    for_bits(record.used, [&](int i) {
      const JointAxis axis = record.axis(i);
      node.law[i] = channel == Channel::Real ? ForceLaw::of(axis, c[i], record.gap[i], ctx.h)
                                             : ForceLaw::of_total(axis, record.bound[i], ctx.h);
    });
  }
}

void JointSystem::take_gradients(NodeState& node, const JointRecord& record, const SolverBody& a,
                                 const SolverBody& b) {
  const SixDofJointDef& def = record.def;
  const JointPlace place = JointPlace::of(def, a, b);
  node.r_a = place.r_a;
  node.r_b = place.r_b;
  if (record.point) {
    node.dir.leftCols<3>().setIdentity();
    node.arm_a.leftCols<3>() = skew(place.r_a);
    node.arm_b.leftCols<3>() = skew(place.r_b);
  }
  if (!node.simple) {
    const Quat basis_a = a.q * def.frame_a.basis;
    const Mat3 axes = basis_a.toRotationMatrix();
    if (!record.point) {
      for (int i = 0; i < 3; ++i) {
        node.dir.col(i) = axes.col(i);
        node.arm_a.col(i) = Vec3(place.r_a + place.d).cross(axes.col(i));
        node.arm_b.col(i) = place.r_b.cross(axes.col(i));
      }
    }
    if ((record.used >> 3) != 0) {
      const JointTurn turn = JointTurn::of(basis_a.conjugate() * (b.q * def.frame_b.basis));
      node.dir.rightCols<4>().setZero();
      node.arm_b.col(kTwist) = axes * turn.twist_gradient();
      node.arm_b.col(4) = axes * turn.swing_gradient(1);
      node.arm_b.col(5) = axes * turn.swing_gradient(2);
      node.arm_b.col(kCone) = axes * turn.u;
      node.arm_a.rightCols<4>() = node.arm_b.rightCols<4>();
    }
  }
}

void JointSystem::add_pull(const JointGraph::Node& plan, NodeState& node, const Vec3& lambda) {
  if (plan.slot_a != kNone) node.pull_a = std::max(node.pull_a, -node.r_a.dot(lambda));
  if (plan.slot_b != kNone) node.pull_b = std::max(node.pull_b, node.r_b.dot(lambda));
}

/// Start the substep anew, now that the load is known.
void JointSystem::restart(const JointGraph::Part& part, std::span<const JointRecord> records,
                          const SubstepContext& ctx) {
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    Slot& slot = slots_[s];
    SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    body.x -= slot.sum_dx;
    body.dx -= slot.sum_dx;
    body.q = rotated(body.q, -slot.sum_dtheta);
    body.dtheta -= slot.sum_dtheta;
  }
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    if (plan.joint == kNone || node.off) continue;
    Vec3 lambda = Vec3::Zero();
    for_bits(records[plan.joint].used & 7u,
             [&](int i) { lambda += node.lambda[i] * node.dir.col(i); });
    add_pull(plan, node, lambda);
    node.lambda.fill(0.0);
  }
}

double JointSystem::iterate(std::uint32_t p, std::span<const JointRecord> records,
                            const SubstepContext& ctx) {
  const JointGraph::Part& part = graph_.parts()[p];
  PartState& state = state_[p];
  if (state.channel == Channel::Total) {
    // Bodies go as far as their targets, so each iteration takes the gradients where they are; and
    // the clean-up, which comes last, has the bodies' own masses again.
    prepare(part, state, records, ctx);
    turn_gradients(part, state, records, ctx);
    return newton(part, state, records, ctx);
  }
  if (!state.prepared) prepare(part, state, records, ctx);
  const double before = state.last_move;
  state.last_move = newton(part, state, records, ctx);
  const auto is_slow = [&] {
    return state.iteration > 1 && state.last_move > kSlow * before && state.last_move > kFine;
  };
  if (is_slow() && !state.restarted) {
    restart(part, records, ctx);
    state.restarted = true;
    state.factored = false;
    state.iteration = 0;
    prepare(part, state, records, ctx);
    state.last_move = newton(part, state, records, ctx);
  } else if (is_slow()) {
    turn_gradients(part, state, records, ctx);
  }
  return state.last_move;
}

/// Take the gradients anew, from the poses as they are.
void JointSystem::turn_gradients(const JointGraph::Part& part, PartState& state,
                                 std::span<const JointRecord> records, const SubstepContext& ctx) {
  const SolverBody ground;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const std::uint32_t joint = graph_.nodes()[k].joint;
    if (joint == kNone || nodes_[k].off) continue;
    const SixDofJointDef& def = records[joint].def;
    take_gradients(nodes_[k], records[joint], body_of(def.a, ctx.bodies, ground),
                   body_of(def.b, ctx.bodies, ground));
  }
  weigh(part, records);
  state.factored = false;
}

double JointSystem::newton(const JointGraph::Part& part, PartState& state,
                           std::span<const JointRecord> records, const SubstepContext& ctx) {
  const bool changed = evaluate(part, records, ctx);
  if (changed || !state.factored) {
    assemble(part);
    factor(part);
    state.factored = true;
  }
  solve(part);
  ++state.iteration;
  return apply(part, ctx);
}

void JointSystem::prepare(const JointGraph::Part& part, PartState& state,
                          std::span<const JointRecord> records, const SubstepContext& ctx) {
  state.prepared = true;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    const SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    slots_[s].inv_mass = body.inv_mass;
    slots_[s].inv_inertia = body.inv_inertia_w;
    slots_[s].dx.setZero();
    slots_[s].dtheta.setZero();
    slots_[s].sum_dx.setZero();
    slots_[s].sum_dtheta.setZero();
    slots_[s].v = body.v;
    slots_[s].w = body.w;
  }
  if (state.channel == Channel::Real) stiffen(part, state, ctx);
  weigh(part, records);
}

void JointSystem::weigh(const JointGraph::Part& part, std::span<const JointRecord> records) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    if (plan.joint == kNone || node.off) continue;
    double inv_mass = 0.0;
    if (plan.slot_a != kNone) inv_mass += slots_[plan.slot_a].inv_mass;
    if (plan.slot_b != kNone) inv_mass += slots_[plan.slot_b].inv_mass;
    if (node.simple) {
      if (plan.slot_a != kNone) {
        node.b_a.leftCols<3>().noalias() =
            slots_[plan.slot_a].inv_inertia.lazyProduct(node.arm_a.leftCols<3>());
      }
      if (plan.slot_b != kNone) {
        node.b_b.leftCols<3>().noalias() =
            slots_[plan.slot_b].inv_inertia.lazyProduct(node.arm_b.leftCols<3>());
      }
    } else {
      for_bits(records[plan.joint].used, [&](int i) {
        if (plan.slot_a != kNone) {
          node.b_a.col(i) = slots_[plan.slot_a].inv_inertia * node.arm_a.col(i);
        }
        if (plan.slot_b != kNone) {
          node.b_b.col(i) = slots_[plan.slot_b].inv_inertia * node.arm_b.col(i);
        }
      });
    }
    for_bits(records[plan.joint].used, [&](int i) {
      double w = inv_mass * node.dir.col(i).squaredNorm();
      if (plan.slot_a != kNone) w += node.arm_a.col(i).dot(node.b_a.col(i));
      if (plan.slot_b != kNone) w += node.arm_b.col(i).dot(node.b_b.col(i));
      node.w[i] = w;
    });
  }
}

/// The part of a body's geometric stiffness that its joints' forces make: a taut link is turned
/// back at a rate that its step may not resolve. With the stiffness of the end of the substep
/// weighted by a share of at least 1/4, any rate is stable and slow turning is not braked
/// (Newmark's average acceleration). As the change of a lever arm against uniform turning is the
/// correction's own, the share adds to inertia: (I + share K) dtheta = r x lambda.
void JointSystem::stiffen(const JointGraph::Part& part, PartState& state,
                          const SubstepContext& ctx) {
  // Until the first iteration dx and dtheta are free: dx.x holds the body's (rate h)^2.
  const auto for_pulls = [&](auto&& visit) {
    for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
      const JointGraph::Node& plan = graph_.nodes()[k];
      const NodeState& node = nodes_[k];
      if (plan.joint != kNone && !node.off) visit(plan, node, node.pull_a, node.pull_b);
    }
  };
  const auto rate = [&](std::uint32_t s, const Vec3& r, double pull) {
    if (pull <= 0.0) return;
    const Mat3& inv = slots_[s].inv_inertia;
    slots_[s].dx.x() += pull * (inv.trace() - r.dot(inv * r) / r.squaredNorm());
  };
  for_pulls([&](const JointGraph::Node& plan, const NodeState& node, double a, double b) {
    rate(plan.slot_a, node.r_a, a);
    rate(plan.slot_b, node.r_b, b);
  });
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    state.stiffness_ratio = std::max(state.stiffness_ratio, slots_[s].dx.x());
  }
  if (state.stiffness_ratio > kStiffFrom) {
    const auto share = [&](std::uint32_t s) {
      return std::clamp((slots_[s].dx.x() - kStiffFrom) / (kStiffTo - kStiffFrom), 0.0, 1.0);
    };
    const auto add = [&](std::uint32_t s, const Vec3& r, double pull) {
      if (pull <= 0.0) return;
      slots_[s].stiffness +=
          share(s) * pull * (Mat3::Identity() - r * r.transpose() / r.squaredNorm());
    };
    for_pulls([&](const JointGraph::Node& plan, const NodeState& node, double a, double b) {
      add(plan.slot_a, node.r_a, a);
      add(plan.slot_b, node.r_b, b);
      if (plan.slot_a == kNone || plan.slot_b == kNone) return;
      // Neighbours that turn against each other at a rate that is not resolved are braked.
      const Vec3 turn = ctx.h * (ctx.bodies[graph_.bodies()[plan.slot_b]].w -
                                 ctx.bodies[graph_.bodies()[plan.slot_a]].w);
      slots_[plan.slot_a].dtheta += kStiffDamping * share(plan.slot_a) * std::max(a, 0.0) * turn;
      slots_[plan.slot_b].dtheta -= kStiffDamping * share(plan.slot_b) * std::max(b, 0.0) * turn;
    });
  }
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    Slot& slot = slots_[s];
    if (slot.dx.x() > kStiffFrom) {
      SolverBody& body = ctx.bodies[graph_.bodies()[s]];
      const Mat3 inv =
          (Mat3::Identity() + (kStiffShare + kStiffDamping) * slot.inv_inertia * slot.stiffness)
              .inverse() *
          slot.inv_inertia;
      slot.inv_inertia = 0.5 * (inv + inv.transpose());
      const Vec3 dtheta = slot.inv_inertia * slot.dtheta;
      body.q = rotated(body.q, dtheta);
      body.dtheta += dtheta;
      slot.sum_dtheta += dtheta;
      slot.stiffness.setZero();
    }
    slot.dx.setZero();
    slot.dtheta.setZero();
  }
}

bool JointSystem::evaluate(const JointGraph::Part& part, std::span<const JointRecord> records,
                           const SubstepContext& ctx) {
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
    const JointRecord& record = records[plan.joint];
    const SolverBody& a = body_of(record.def.a, ctx.bodies, ground);
    const SolverBody& b = body_of(record.def.b, ctx.bodies, ground);
    if (node.simple) {
      const JointPlace place = JointPlace::of(record.def, a, b);
      changed = changed || node.n != 3;
      node.n = 3;
      for (int i = 0; i < 3; ++i) {
        node.coordinate[i] = static_cast<std::uint8_t>(i);
        const ForceLaw& law = node.law[i];
        node.at[i] = part.regular ? law.at : std::max(law.at, kRedundancy * node.w[i]);
        right[i] = -(place.d[i] - law.target) - node.at[i] * node.lambda[i];
      }
      continue;
    }
    double c[kCoordinates];
    coordinates(record, a, b, record.twist, c);
    int n = 0;
    for_bits(record.used, [&](int i) {
      Segment segment = node.law[i].segment(c[i], node.lambda[i], node.w[i]);
      if (segment.kind != node.last_kind[i]) ++node.flips[i];
      const bool stop =
          segment.kind == Segment::Kind::Lower || segment.kind == Segment::Kind::Upper;
      if (stop && node.flips[i] > kFlips) {
        // It cannot settle with its neighbours: let go, the next substep sees where it stands.
        segment = {Segment::Kind::Force, c[i], 1e9 * node.w[i], 0.0};
      }
      node.last_kind[i] = segment.kind;
      if (segment.kind == Segment::Kind::None) return;
      changed = changed || n >= node.n || node.coordinate[n] != i || node.kind[n] != segment.kind;
      node.coordinate[n] = static_cast<std::uint8_t>(i);
      node.kind[n] = segment.kind;
      node.at[n] = part.regular ? segment.at : std::max(segment.at, kRedundancy * node.w[i]);
      right[n] = -(c[i] - segment.target) - node.at[n] * (node.lambda[i] - segment.offset);
      ++n;
    });
    changed = changed || n != node.n;
    node.n = n;
  }
  return changed;
}

double JointSystem::apply(const JointGraph::Part& part, const SubstepContext& ctx) {
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    NodeState& node = nodes_[k];
    if (plan.joint == kNone || node.n == 0) continue;
    const double* dlambda = &right_[plan.right];
    Vec3 p = Vec3::Zero();
    Vec3 turn_a = Vec3::Zero();
    Vec3 turn_b = Vec3::Zero();
    if (node.simple) {
      p = Eigen::Map<const Vec3>(dlambda);
      for (int i = 0; i < 3; ++i) node.lambda[i] += dlambda[i];
      if (plan.slot_a != kNone) turn_a = node.b_a.leftCols<3>().lazyProduct(p);
      if (plan.slot_b != kNone) turn_b = node.b_b.leftCols<3>().lazyProduct(p);
    } else {
      for (int r = 0; r < node.n; ++r) {
        const int i = node.coordinate[r];
        node.lambda[i] += dlambda[r];
        p += dlambda[r] * node.dir.col(i);
        if (plan.slot_a != kNone) turn_a += dlambda[r] * node.b_a.col(i);
        if (plan.slot_b != kNone) turn_b += dlambda[r] * node.b_b.col(i);
      }
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
  // A turn that no gradient reaches is taken in parts.
  double turn2 = 0.0;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    turn2 = std::max(turn2, slots_[s].dtheta.squaredNorm());
  }
  if (turn2 > kTrust * kTrust) {
    const double share = kTrust / std::sqrt(turn2);
    for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
      slots_[s].dx *= share;
      slots_[s].dtheta *= share;
    }
    for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
      NodeState& node = nodes_[k];
      if (graph_.nodes()[k].joint == kNone) continue;
      const double* dlambda = &right_[graph_.nodes()[k].right];
      for (int r = 0; r < node.n; ++r)
        node.lambda[node.coordinate[r]] -= (1.0 - share) * dlambda[r];
    }
  }
  double largest = 0.0;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    Slot& slot = slots_[s];
    SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    body.x += slot.dx;
    body.dx += slot.dx;
    body.q = rotated(body.q, slot.dtheta);
    body.dtheta += slot.dtheta;
    slot.sum_dx += slot.dx;
    slot.sum_dtheta += slot.dtheta;
    largest = std::max({largest, slot.dx.squaredNorm(), slot.dtheta.squaredNorm()});
    slot.dx.setZero();
    slot.dtheta.setZero();
  }
  return std::sqrt(largest);
}

/// Rigid locks and limits do no work. Where those of a part did, since bodies turned further within
/// a substep than its gradients can follow, the surplus is taken back from the motion of the part
/// against its mean: it may shake where it is not resolved, but not more and more.
void JointSystem::guard(const JointGraph::Part& part, std::span<JointRecord> records,
                        const SubstepContext& ctx) {
  double work = 0.0;
  double energy = 0.0;  // before, against the mean
  double mass = 0.0;
  Vec3 mean = Vec3::Zero();
  const double rate = 1.0 / ctx.h;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    const SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    mass += 1.0 / body.inv_mass;
    mean += body.v / body.inv_mass;
  }
  mean /= mass;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    const Slot& slot = slots_[s];
    const SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    const Vec3 dv = rate * slot.sum_dx;
    const Vec3 dw = rate * slot.sum_dtheta;
    const Mat3 inertia = body.inv_inertia_w.inverse();
    // The inertia turns with the body, the angular momentum does not.
    const Vec3 momentum = inertia * (slot.w + dw);
    const Vec3 momentum_l = exp_map(-slot.sum_dtheta) * momentum;
    work += dv.dot(slot.v + 0.5 * dv) / body.inv_mass +
            0.5 * (momentum_l.dot(body.inv_inertia_w * momentum_l) - slot.w.dot(inertia * slot.w));
    energy += 0.5 * ((body.v - mean).squaredNorm() / body.inv_mass + body.w.dot(inertia * body.w));
  }
  std::uint32_t first = part.node;
  while (graph_.nodes()[first].joint == kNone) ++first;
  double& surplus = records[graph_.nodes()[first].joint].surplus;
  const double room = kSurplus * energy;
  surplus = std::max(surplus + work, -room);
  if (!(surplus > room)) return;
  const double excess = surplus - room;
  const double scale = std::sqrt(std::max(0.0, 1.0 - excess / energy));
  surplus = room;
  for (std::uint32_t s = part.body; s < part.body + part.body_count; ++s) {
    SolverBody& body = ctx.bodies[graph_.bodies()[s]];
    body.v = mean + scale * (body.v - mean);
    body.w *= scale;
  }
}

double JointSystem::turn_rate(std::uint32_t p, std::span<const JointRecord> records,
                              std::span<const SolverBody> bodies) const {
  const JointGraph::Part& part = graph_.parts()[p];
  const SolverBody ground;
  double largest = 0.0;
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    if (plan.joint == kNone) continue;
    const SixDofJointDef& def = records[plan.joint].def;
    const SolverBody& a = body_of(def.a, bodies, ground);
    const SolverBody& b = body_of(def.b, bodies, ground);
    const Vec3 spin = b.w - a.w;
    // An arm much shorter than the radius of gyration says little.
    const auto rate = [&](const SolverBody& body, const Vec3& anchor) {
      if (body.inv_mass == 0.0) return;
      const double gyration2 = 3.0 * body.inv_mass / body.inv_inertia_w.trace();
      const double turn2 = spin.cross(body.q * anchor).squaredNorm();
      largest = std::max(largest, turn2 / (anchor.squaredNorm() + gyration2));
    };
    rate(a, def.frame_a.anchor);
    rate(b, def.frame_b.anchor);
  }
  return std::sqrt(largest);
}

void JointSystem::finish(std::uint32_t p, std::span<JointRecord> records,
                         const SubstepContext& ctx) {
  const JointGraph::Part& part = graph_.parts()[p];
  if (passive_[p] != 0) guard(part, records, ctx);
  const double inverse_h2 = 1.0 / (ctx.h * ctx.h);
  for (std::uint32_t k = part.node; k < part.node + part.node_count; ++k) {
    const JointGraph::Node& plan = graph_.nodes()[k];
    const NodeState& node = nodes_[k];
    if (plan.joint == kNone || node.off) continue;
    JointRecord& record = records[plan.joint];
    JointState& state = record.state;
    state.force.setZero();
    state.torque.setZero();
    for_bits(record.used, [&](int i) {
      const double load = inverse_h2 * node.lambda[i];
      if (i < 6) state.load[i] = load;
      if (i < 3) {
        state.force += load * node.dir.col(i);
      } else {
        state.torque += load * node.arm_b.col(i);
      }
    });
    const SixDofJointDef& def = record.def;
    state.broken = (def.break_force > 0.0 && state.force.norm() > def.break_force) ||
                   (def.break_torque > 0.0 && state.torque.norm() > def.break_torque);
  }
}

}  // namespace tandem::pbd
