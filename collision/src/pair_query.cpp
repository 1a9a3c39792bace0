// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "pair_query.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "box_box.h"
#include "convex_query.h"
#include "sphere_contact.h"

namespace tandem::collision {
namespace {

using pbd::Pose;
using pbd::Quat;

/// The smaller part is measured in the frame of the larger one.
bool measures_a(const QueryPair& pair) {
  return !pair.b->is_convex() || pair.a->reach <= pair.b->reach;
}

struct Roles {
  const Collider& measured;
  const Collider& frame;
};

Roles roles(const QueryPair& pair) {
  return measures_a(pair) ? Roles{*pair.a, *pair.b} : Roles{*pair.b, *pair.a};
}

Vec3 relative_position(const Roles& r) {
  return pbd::rotate(r.frame.body.orientation.conjugate(),
                     r.measured.body.position - r.frame.body.position);
}
Quat relative_orientation(const Roles& r) {
  return r.frame.body.orientation.conjugate() * r.measured.body.orientation;
}

/// Whether the measured part has moved less than `limit`, m, and how far. A body without a round
/// core must also have rotated less than an angle, given as the sine of its half.
bool moved_less(const Roles& r, const PairCache& cache, double limit, double max_sine,
                double& distance) {
  const Collider& measured = r.measured;
  const auto& q = cache.orientation;
  const Pose then{cache.position, Quat(q[3], q[0], q[1], q[2])};
  const Vec3 position = relative_position(r);
  if (measured.kind == Kind::Sphere && measured.local_identity) {
    distance = (position - then.position).norm();
    return distance < limit;
  }
  const auto* capsule = std::get_if<Capsule>(&measured.def.shape);
  if (measured.kind == Kind::Sphere || capsule != nullptr) {
    // Round shapes by their cores: rolling about the core is no motion.
    const Pose now{position, relative_orientation(r)};
    const auto displacement = [&](const Vec3& point_l) {
      return (now.to_world(point_l) - then.to_world(point_l)).norm();
    };
    const Vec3& middle = measured.def.local.position;
    const Vec3 arm = capsule != nullptr
                         ? Vec3(capsule->half_height * measured.local_rotation().col(2))
                         : Vec3(Vec3::Zero());
    distance = std::max(displacement(middle + arm), displacement(middle - arm));
    return distance < limit;
  }
  distance = (position - then.position).norm();
  if (distance >= limit) return false;
  const double half_sine = (then.orientation.conjugate() * relative_orientation(r)).vec().norm();
  distance += 2.0 * half_sine * measured.reach;
  return half_sine <= max_sine && distance < limit;
}

/// Whether an omitted point may carry load by now. Such a point sinks until it is checked, and is
/// then pushed out, which lifts the body: a scanned parcel of 0.4 m sank by 1.5 mm and rocked at
/// 0.14 rad/s for ever.
/// @param distance  m, from moved_less(): no point has moved further
bool left_out_may_bear(const QueryPair& pair, const Roles& r, const PairCache& cache,
                       double distance) {
  for (const ContactPatch* p = cache.patches; p != nullptr; p = p->next) {
    const auto left_out = static_cast<double>(p->left_out);
    if (distance <= left_out) continue;
    const auto& q = cache.orientation;
    const Quat then(q[3], q[0], q[1], q[2]);
    const double half_sine = (then.conjugate() * relative_orientation(r)).vec().norm();
    const bool in_frame = &r.frame == (p->in_a ? pair.a : pair.b);
    const Vec3 normal = in_frame ? p->normal_l : pbd::rotate(then, p->normal_l);
    const double along = std::abs(normal.dot(relative_position(r) - cache.position));
    if (along + 2.0 * half_sine * r.measured.reach > left_out) return true;
  }
  return false;
}

/// Writes raw manifolds over the cache's patches, reusing their memory.
class PatchWriter {
 public:
  PatchWriter(const QueryPair& pair, PairCache& cache, PatchPool& pool)
      : pair_(pair), pool_(pool), link_(&cache.patches) {}

  /// @param origin  m, world: origin of the manifold's positions
  void store(const RawManifold& raw, const Vec3& origin) {
    if (raw.count == 0 || raw.cluster >= (1u << kClusterBits)) return;
    ContactPatch& patch = next();
    const Collider& a = *pair_.a;
    const Collider& b = *pair_.b;
    patch.in_a =
        raw.owner == FaceOwner::A || (raw.owner == FaceOwner::None && b.dynamic && !a.dynamic);
    patch.normal_l = (patch.in_a ? a : b).direction_to_body(raw.normal);
    // A cylinder on its side: anchors on its axis.
    const double roll_a = a.kind == Kind::Cylinder ? rolling(a, raw.normal) : 0.0;
    const double roll_b = b.kind == Kind::Cylinder ? rolling(b, -raw.normal) : 0.0;
    patch.radius_a = radius_of(a) + roll_a;
    patch.radius_b = radius_of(b) + roll_b;
    // Never rounded up.
    patch.left_out = std::nextafter(static_cast<float>(raw.left_out), 0.0f);
    patch.cluster = static_cast<std::uint16_t>(raw.cluster);
    patch.count = static_cast<std::uint8_t>(std::min<int>(raw.count, ContactPatch::kMaxPoints));
    const Vec3 to_a = origin - a.position - roll_a * raw.normal;
    const Vec3 to_b = origin - b.position + roll_b * raw.normal;
    for (int i = 0; i < patch.count; ++i) {
      patch.anchor_a_l[i] = a.to_body(raw.points[i].on_a + to_a);
      patch.anchor_b_l[i] = b.to_body(raw.points[i].on_b + to_b);
      patch.features[i] = raw.points[i].feature;
    }
  }
  /// Stores a contact of sphere a.
  void store_sphere(const SphereTouch& touch) {
    if (touch.cluster >= (1u << kClusterBits)) return;
    ContactPatch& patch = next();
    const Collider& a = *pair_.a;
    const Collider& b = *pair_.b;
    const Vec3 normal = b.rotation * touch.normal;
    patch.in_a = false;
    patch.normal_l = b.direction_to_body(normal);
    patch.radius_a = radius_of(a);
    patch.radius_b = 0.0;
    patch.left_out = HUGE_VALF;
    patch.cluster = static_cast<std::uint16_t>(touch.cluster);
    patch.count = 1;
    patch.anchor_a_l[0] = a.def.local.position;
    patch.anchor_b_l[0] = b.to_body(b.rotation * touch.point);
    patch.features[0] = 0;
  }
  /// Gives the unused patches back.
  void finish() { pool_.give(std::exchange(*link_, nullptr)); }

 private:
  ContactPatch& next() {
    if (*link_ == nullptr) *link_ = pool_.take();
    ContactPatch& patch = **link_;
    link_ = &patch.next;
    return patch;
  }

  static double radius_of(const Collider& c) {
    if (const auto* s = std::get_if<Sphere>(&c.def.shape)) return s->radius;
    if (const auto* k = std::get_if<Capsule>(&c.def.shape)) return k->radius;
    return 0.0;
  }

  static double rolling(const Collider& c, const Vec3& direction) {
    return rolling_radius(c.core(c.position), direction);
  }

  const QueryPair& pair_;
  PatchPool& pool_;
  ContactPatch** link_;
};

/// Collects the pair's last patches for the surface queries.
void trace_patches(const QueryPair& pair, const Collider& mesh, const PairCache& cache,
                   std::vector<PatchTrace>& before) {
  before.clear();
  for (const ContactPatch* p = cache.patches; p != nullptr; p = p->next) {
    // Patches are stored in the body's frame, normals are compared in the mesh's.
    const bool other_frame = !pair.a->is_surface() && !mesh.local_identity;
    before.push_back(
        {other_frame ? Vec3(mesh.local_rotation().transpose() * p->normal_l) : p->normal_l,
         p->features, p->cluster, p->count});
  }
}

void query_sphere_on_surface(const QueryPair& pair, const Reach& reach, PairCache& cache,
                             QueryScratch& scratch, PatchWriter& writer) {
  const Collider& mesh = *pair.b;
  trace_patches(pair, mesh, cache, scratch.before);
  if (cache.triangles == nullptr) cache.triangles = std::make_unique<TriangleList>();
  const Vec3 centre = mesh.rotation.transpose() * -(mesh.position - pair.a->position);
  const Vec3 sweep = mesh.rotation.transpose() * reach.way;
  const double radius = std::get<Sphere>(pair.a->def.shape).radius;
  if (const auto* field = std::get_if<Field>(&mesh.def.shape)) {
    touch_surface(centre, radius, reach.margin, sweep, **field, scratch.before, *cache.triangles,
                  scratch.sphere);
  } else {
    touch_surface(centre, radius, reach.margin, sweep, *std::get<Mesh>(mesh.def.shape),
                  scratch.before, *cache.triangles, scratch.sphere);
  }
  for (const SphereTouch& touch : scratch.sphere.touches) writer.store_sphere(touch);
}

void query_mesh(const QueryPair& pair, const Reach& reach, PairCache& cache, QueryScratch& scratch,
                std::size_t& queries) {
  const Vec3& origin = pair.a->position;
  const Collider& mesh = pair.a->is_surface() ? *pair.a : *pair.b;
  const MeshPose pose{mesh.rotation, mesh.position - origin};
  scratch.raw.clear();
  trace_patches(pair, mesh, cache, scratch.before);
  if (pair.a->is_surface()) {
    const Vec3 n = pair.b->plane_normal();
    const double offset =
        std::get<HalfSpace>(pair.b->def.shape).offset + n.dot(pair.b->position - origin);
    scratch.raw.push_back(mesh_half_space(*std::get<Mesh>(mesh.def.shape), pose, n, offset,
                                          reach.margin, scratch.before, scratch.mesh));
    return;
  }
  if (cache.triangles == nullptr) cache.triangles = std::make_unique<TriangleList>();
  const ConvexCore core = pair.a->core(origin);
  if (const auto* field = std::get_if<Field>(&mesh.def.shape)) {
    queries += collide_mesh(core, **field, pose, reach, scratch.before, *cache.triangles,
                            scratch.mesh, scratch.raw);
  } else {
    queries += collide_mesh(core, *std::get<Mesh>(mesh.def.shape), pose, reach, scratch.before,
                            *cache.triangles, scratch.mesh, scratch.raw);
  }
}

/// Share of the path that rotation may add if the direction of the path is to count.
constexpr double kTurning = 0.5;

/// Share of the smaller size: bound on a collider's motion by itself. Columns of 12 that fall from
/// up to 50 edges hold with it, and with half of it, as well as without a bound; a swarm of 500
/// cubes at 100 m/s takes 0.25 s instead of 0.46 (0.16 if such motion is ignored).
constexpr double kAlone = 4.0;

}  // namespace

QueryPair order_pair(const Collider& one, const Collider& other) {
  const auto order = [](const Collider& c) { return std::tuple(c.kind, c.rank.body); };
  const Collider& first = one.rank.own < other.rank.own ? one : other;
  const Collider& second = one.rank.own < other.rank.own ? other : one;
  if (order(second) < order(first)) return {&second, &first, true};
  return {&first, &second, false};
}

PairReach reach_of(const QueryPair& pair, double dt) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  PairReach reach;
  reach.speculative = std::min(a.margins.speculative, b.margins.speculative);
  reach.recycle = std::min(a.margins.recycle, b.margins.recycle);
  reach.sweep = dt * (b.motion().twist.linear - a.motion().twist.linear);
  double sweep2 = pbd::dot(reach.sweep, reach.sweep);
  // The contact is on both, so it is no further from one than by way of the other.
  const double distance = (b.body.position - a.body.position).norm();
  const double arm_a = std::min(a.reach, distance + b.reach);
  const double arm_b = std::min(b.reach, distance + a.reach);
  const double turning_a = a.motion().turn * arm_a;
  const double turning_b = b.motion().turn * arm_b;
  reach.turning = turning_a + turning_b;
  const auto is_ball = [](const Collider& c) { return c.kind == Kind::Sphere && c.local_identity; };
  const double seen = (is_ball(a) ? 0.0 : turning_a) + (is_ball(b) ? 0.0 : turning_b);
  if (seen < kTurning * std::sqrt(sweep2)) reach.way = reach.sweep;
  if (a.dynamic && b.dynamic) {
    const double most = kAlone * std::min(a.size, b.size);
    const auto alone = [&](const Collider& c, Vec3& way) {
      way = dt * c.motion().twist.linear;
      const double way2 = pbd::dot(way, way);
      if (way2 > most * most) way *= most / std::sqrt(way2);
      sweep2 = std::max(sweep2, std::min(way2, most * most));
    };
    alone(a, reach.alone_a);
    alone(b, reach.alone_b);
  }
  reach.margin = reach.speculative + std::sqrt(sweep2) + reach.turning;
  return reach;
}

PairReach reach_at_rest(const QueryPair& pair) {
  PairReach reach;
  reach.speculative = std::min(pair.a->margins.speculative, pair.b->margins.speculative);
  reach.recycle = std::min(pair.a->margins.recycle, pair.b->margins.recycle);
  reach.margin = reach.speculative;
  return reach;
}

bool is_direct(const QueryPair& pair) {
  return pair.a->kind == Kind::Sphere && has_sphere_contact(pair.b->kind);
}

bool still_apart(const QueryPair& pair, const PairReach& reach, const PairCache& cache) {
  if (cache.patches != nullptr || cache.axis >= 15) return false;
  const BoxPose a{pair.a->rotation, std::get<Box>(pair.a->def.shape).half_extents};
  const BoxPose b{pair.b->rotation, std::get<Box>(pair.b->def.shape).half_extents};
  return box_separation(a, b, pair.b->position - pair.a->position, cache.axis) >= reach.margin;
}

bool can_recycle(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
                 double max_angle) {
  if (!cache.valid || reach.recycle <= 0.0) return false;
  // The sine is within 1e-3 for angles up to 0.1 rad, which is all that is needed.
  double distance = 0.0;
  // Then the last search covered everything that matters now.
  const Roles r = roles(pair);
  return moved_less(r, cache, reach.recycle, 0.5 * max_angle, distance) &&
         distance + reach.margin <= static_cast<double>(cache.margin) &&
         !left_out_may_bear(pair, r, cache, distance);
}

std::size_t query_pair(const QueryPair& pair, const PairReach& reach, PairCache& cache,
                       PatchPool& pool, QueryScratch& scratch) {
  const Vec3& origin = pair.a->position;
  const Collider& upper =
      pair.b->dynamic && !(pair.a->dynamic && measures_a(pair)) ? *pair.b : *pair.a;
  const Reach wanted{reach.margin + reach.recycle, reach.sweep, reach.way,
                     upper.body.position - origin};
  std::size_t queries = 0;
  PatchWriter writer(pair, cache, pool);
  if (pair.a->kind == Kind::Sphere && pair.b->is_surface()) {
    query_sphere_on_surface(pair, wanted, cache, scratch, writer);
  } else if (pair.b->is_surface() || pair.a->is_surface()) {
    query_mesh(pair, wanted, cache, scratch, queries);
    std::sort(scratch.raw.begin(), scratch.raw.end(),
              [](const RawManifold& l, const RawManifold& r) { return l.cluster < r.cluster; });
    for (const RawManifold& raw : scratch.raw) writer.store(raw, origin);
  } else {
    RawManifold manifold;
    queries = query_convex(pair, wanted, cache, manifold);
    writer.store(manifold, origin);
  }
  writer.finish();
  const Roles r = roles(pair);
  const Quat orientation = relative_orientation(r);
  cache.position = relative_position(r);
  for (int i = 0; i < 4; ++i) cache.orientation[i] = static_cast<float>(orientation.coeffs()[i]);
  // Never rounded up: nothing beyond it was searched.
  cache.margin = std::nextafter(static_cast<float>(wanted.margin), 0.0f);
  cache.valid = true;
  return queries;
}

}  // namespace tandem::collision
