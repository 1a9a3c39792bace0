// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "pair_query.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "fcl_bridge.h"

namespace tandem::collision {
namespace {

using pbd::Pose;
using pbd::Quat;

bool is_sphere(const Collider& c) { return c.rank == 0; }

/// Two balls about their bodies' origins: turning changes nothing.
bool is_central(const QueryPair& pair) {
  return is_sphere(*pair.a) && is_sphere(*pair.b) && pair.a->def.local.position.isZero(0.0) &&
         pair.b->def.local.position.isZero(0.0);
}

/// The smaller part is measured in the frame of the larger one.
bool measures_a(const QueryPair& pair) {
  return !pair.b->is_convex() || pair.a->reach <= pair.b->reach;
}

Pose relative_pose(const QueryPair& pair) {
  const Collider& measured = measures_a(pair) ? *pair.a : *pair.b;
  const Collider& frame = measures_a(pair) ? *pair.b : *pair.a;
  if (is_central(pair)) {
    return {measured.body.position - frame.body.position, Quat::Identity()};
  }
  const Quat inverse = frame.body.orientation.conjugate();
  return {inverse * (measured.body.position - frame.body.position),
          inverse * measured.body.orientation};
}

/// How far the measured part has moved since, m; infinite where it turned by more than max_angle.
double moved(const QueryPair& pair, const Pose& now, const Pose& then, double max_angle) {
  const Collider& measured = measures_a(pair) ? *pair.a : *pair.b;
  const auto displacement = [&](const Vec3& point_l) {
    return (now.to_world(point_l) - then.to_world(point_l)).norm();
  };
  const Pose& local = measured.def.local;
  // Round shapes by their cores: rolling about the core is no motion.
  if (is_sphere(measured)) return displacement(local.position);
  if (const auto* capsule = std::get_if<Capsule>(&measured.def.shape)) {
    const Vec3 arm = capsule->half_height * measured.local_rotation.col(2);
    return std::max(displacement(local.position + arm), displacement(local.position - arm));
  }
  const double half_sine = (then.orientation.conjugate() * now.orientation).vec().norm();
  if (half_sine > std::sin(0.5 * max_angle)) return HUGE_VAL;
  return (now.position - then.position).norm() + 2.0 * half_sine * measured.reach;
}

void store(const QueryPair& pair, const RawManifold& raw, const Vec3& origin, PairCache& cache) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  ContactPatch& patch = cache.patches.emplace_back();
  patch.in_a =
      raw.owner == FaceOwner::A || (raw.owner == FaceOwner::None && b.dynamic && !a.dynamic);
  const Pose& frame = patch.in_a ? a.body : b.body;
  patch.normal_l = frame.orientation.conjugate() * raw.normal;
  patch.central = is_central(pair);
  const auto radius = [](const Collider& c) {
    if (const auto* s = std::get_if<Sphere>(&c.def.shape)) return s->radius;
    if (const auto* k = std::get_if<Capsule>(&c.def.shape)) return k->radius;
    return 0.0;
  };
  patch.radius_a = radius(a);
  patch.radius_b = radius(b);
  patch.cluster = raw.cluster;
  patch.count = std::min<int>(raw.count, pbd::Manifold::kMaxPoints);
  for (int i = 0; i < patch.count; ++i) {
    patch.points[i].anchor_a_l =
        a.body.orientation.conjugate() * (raw.points[i].on_a + (origin - a.body.position));
    patch.points[i].anchor_b_l =
        b.body.orientation.conjugate() * (raw.points[i].on_b + (origin - b.body.position));
    patch.points[i].feature = raw.points[i].feature;
  }
}

std::size_t query_convex(const QueryPair& pair, const Reach& reach, const PairCache& cache,
                         const Vec3& origin, RawManifold& out) {
  const ConvexCore a = pair.a->core(origin);
  if (pair.b->is_half_space()) {
    const Vec3 n = pair.b->plane_normal();
    const double offset = pair.b->plane_offset() - n.dot(origin);
    if (near_half_space(a, n, offset, reach.margin)) {
      out = half_space_manifold(a, n, offset, reach.margin);
    }
    return 1;
  }
  const ConvexCore b = pair.b->core(origin);
  const Direction direction = query_direction(a, b, reach.margin);
  if (direction.status == Direction::Status::Apart) return 1;
  out = build_manifold(a, b, choose_axis(a, b, direction), reach);
  std::array<std::uint32_t, 4> kept{};
  const int kept_count = cache.patches.empty() ? 0 : cache.patches[0].count;
  for (int i = 0; i < kept_count; ++i) kept[i] = cache.patches[0].points[i].feature;
  out.count = reduce(out.points.data(), out.count, out.normal, 1e-3 * std::min(a.size, b.size),
                     kept.data(), kept_count);
  return 1;
}

}  // namespace

QueryPair order_pair(const Collider& low, const Collider& high) {
  const auto order = [](const Collider& c) { return std::tuple(c.rank, c.def.body.index); };
  if (order(high) < order(low)) return {&high, &low, true};
  return {&low, &high, false};
}

PairReach reach_of(const QueryPair& pair, double dt) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  PairReach reach;
  reach.speculative = std::min(a.speculative, b.speculative);
  reach.recycle = std::min(a.recycle, b.recycle);
  reach.sweep = dt * (b.twist.linear - a.twist.linear);
  // The contact lies on both, so it is no further from one than the way over the other.
  const double distance = (b.body.position - a.body.position).norm();
  const double arm_a = std::min(a.reach, distance + b.reach);
  const double arm_b = std::min(b.reach, distance + a.reach);
  reach.turning = dt * (a.twist.angular.norm() * arm_a + b.twist.angular.norm() * arm_b);
  reach.margin = reach.speculative + reach.sweep.norm() + reach.turning;
  return reach;
}

bool can_recycle(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
                 double max_angle) {
  if (!cache.valid || reach.recycle <= 0.0) return false;
  const double distance = moved(pair, relative_pose(pair), cache.relative, max_angle);
  // Within what was asked then lies all that matters now.
  return distance < reach.recycle && distance + reach.margin <= cache.margin;
}

std::size_t query_pair(const QueryPair& pair, const PairReach& reach, PairCache& cache,
                       QueryScratch& scratch) {
  const Vec3 origin = pair.a->position;
  const Reach wanted{reach.margin + reach.recycle, reach.sweep};
  std::size_t queries = 0;
  scratch.raw.clear();
  if (pair.b->is_mesh() || pair.a->is_mesh()) {
    const Collider& mesh = pair.a->is_mesh() ? *pair.a : *pair.b;
    const TriangleMesh& triangles = *std::get<Mesh>(mesh.def.shape);
    const MeshPose pose{mesh.rotation, mesh.position - origin};
    if (pair.a->is_mesh()) {
      const Vec3 n = pair.b->plane_normal();
      scratch.raw.push_back(mesh_half_space(triangles, pose, n,
                                            pair.b->plane_offset() - n.dot(origin), wanted.margin,
                                            cache.patches, scratch.mesh));
    } else {
      // Patches are kept in the body's frame, normals are compared in the mesh's own.
      for (ContactPatch& patch : cache.patches) {
        patch.normal_l = mesh.local_rotation.transpose() * patch.normal_l;
      }
      queries = collide_mesh(pair.a->core(origin), triangles, pose, wanted, cache.patches,
                             scratch.mesh, scratch.raw);
    }
  } else {
    RawManifold manifold;
    queries = query_convex(pair, wanted, cache, origin, manifold);
    scratch.raw.push_back(manifold);
  }
  cache.patches.clear();
  for (const RawManifold& raw : scratch.raw) {
    if (raw.count > 0 && raw.cluster < (1u << kClusterBits)) store(pair, raw, origin, cache);
  }
  std::sort(cache.patches.begin(), cache.patches.end(),
            [](const ContactPatch& l, const ContactPatch& r) { return l.cluster < r.cluster; });
  cache.relative = relative_pose(pair);
  cache.margin = wanted.margin;
  cache.valid = true;
  return queries;
}

void emit(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
          std::uint64_t key_base, std::vector<pbd::Manifold>& out) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  for (const ContactPatch& patch : cache.patches) {
    Vec3 normal = (patch.in_a ? a.body : b.body).orientation * patch.normal_l;
    if (patch.central) {
      const Vec3 between = b.position - a.position;
      const double distance = between.norm();
      if (distance > 1e-9) normal = between / distance;
    }
    pbd::Manifold m;
    m.key = key_base + patch.cluster;
    m.normal = normal;
    m.radius_a = patch.radius_a;
    m.radius_b = patch.radius_b;
    m.friction = combined_friction(a.def.material, b.def.material);
    m.restitution = combined_restitution(a.def.material, b.def.material);
    const double margin =
        reach.speculative + std::max(0.0, -normal.dot(reach.sweep)) + reach.turning;
    for (int i = 0; i < patch.count; ++i) {
      const pbd::ManifoldPoint& point = patch.points[i];
      // Between the bodies' origins first: far from the world's origin no digits are lost.
      const Vec3 between =
          (b.body.position - a.body.position) +
          (b.body.orientation * point.anchor_b_l - a.body.orientation * point.anchor_a_l);
      if (normal.dot(between) - patch.radius_a - patch.radius_b >= margin) continue;
      m.points[m.count++] = point;
    }
    if (m.count == 0) continue;
    m.body_a = a.def.body.index;
    m.body_b = b.def.body.index;
    if (pair.swapped) {
      std::swap(m.body_a, m.body_b);
      std::swap(m.radius_a, m.radius_b);
      m.normal = -m.normal;
      for (int i = 0; i < m.count; ++i) std::swap(m.points[i].anchor_a_l, m.points[i].anchor_b_l);
    }
    out.push_back(m);
  }
}

}  // namespace tandem::collision
