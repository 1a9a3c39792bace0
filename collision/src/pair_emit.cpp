// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Makes the manifolds of this step from a pair's cache.
#include <algorithm>
#include <array>
#include <utility>

#include "meeting.h"
#include "pair_query.h"
#include "sphere_contact.h"
#include "tandem/pbd/math.h"

namespace tandem::collision {
namespace {

/// Sets the material of the pair.
void set_material(const Collider& a, const Collider& b, pbd::Manifold& m) {
  m.friction = combined_friction(a.def.material, b.def.material);
  m.restitution = combined_restitution(a.def.material, b.def.material);
}

/// Puts the manifold into the order of the colliders.
void finish_manifold(const QueryPair& pair, std::uint64_t key, pbd::Manifold& m) {
  constexpr std::uint64_t kClusterMask = (std::uint64_t{1} << kClusterBits) - 1;
  const Collider& first = pair.swapped ? *pair.b : *pair.a;
  const Collider& second = pair.swapped ? *pair.a : *pair.b;
  m.key = key;
  m.order = (std::uint64_t{first.rank.own} << (kIndexBits + kClusterBits)) |
            (std::uint64_t{second.rank.own} << kClusterBits) | (key & kClusterMask);
  m.version = (first.generation ^ (second.generation << 16u)) & 0x7fffffffu;
  set_material(*pair.a, *pair.b, m);
  m.body_a = pair.a->def.body.index;
  m.body_b = pair.b->def.body.index;
  if (!pair.swapped) return;
  std::swap(m.body_a, m.body_b);
  std::swap(m.radius_a, m.radius_b);
  m.normal = -m.normal;
  for (int i = 0; i < m.count; ++i) std::swap(m.points[i].anchor_a_l, m.points[i].anchor_b_l);
}

}  // namespace

void emit(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
          std::uint64_t key_base, std::vector<pbd::Manifold>& out) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  for (const ContactPatch* patch = cache.patches; patch != nullptr; patch = patch->next) {
    const Collider& frame = patch->in_a ? a : b;
    const Collider& other = patch->in_a ? b : a;
    const Vec3 normal = pbd::rotate(frame.body.orientation, patch->normal_l);
    const Vec3 in_other = pbd::rotate(other.body.orientation.conjugate(), normal);
    const Vec3& n_a = patch->in_a ? patch->normal_l : in_other;
    const Vec3& n_b = patch->in_a ? in_other : patch->normal_l;
    const double margin = reach.along(normal);
    // Relative to the bodies' origins first, to keep precision far from the world's origin.
    const double between = pbd::dot(normal, b.body.position - a.body.position) - patch->radius_a -
                           patch->radius_b - margin;
    std::array<bool, ContactPatch::kMaxPoints> near{};
    bool any = false;
    for (int i = 0; i < patch->count; ++i) {
      near[i] =
          between + (pbd::dot(n_b, patch->anchor_b_l[i]) - pbd::dot(n_a, patch->anchor_a_l[i])) <
          0.0;
      any = any || near[i];
    }
    if (!any) continue;
    pbd::Manifold& m = out.emplace_back();
    m.normal = normal;
    m.radius_a = patch->radius_a;
    m.radius_b = patch->radius_b;
    for (int i = 0; i < patch->count; ++i) {
      if (!near[i]) continue;
      m.points[m.count++] = {patch->anchor_a_l[i], patch->anchor_b_l[i], patch->features[i]};
    }
    finish_manifold(pair, key_base + patch->cluster, m);
  }
}

void emit_direct(const QueryPair& pair, const PairReach& reach, std::uint64_t key_base,
                 std::vector<pbd::Manifold>& out) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  const double radius = std::get<Sphere>(a.def.shape).radius;
  Vec3 centre = a.position;
  SphereContact contact = sphere_contact(centre, b);
  const auto approach = [&] {
    return Approach{contact.normal, contact.distance - radius - contact.radius_b};
  };
  const auto look = [&](double share) {
    centre = a.position - share * reach.way;
    contact = sphere_contact(centre, b);
    return approach();
  };
  share_to_meeting(reach.way, kMet * std::min(a.size, b.size), approach(), look);
  const double gap = approach().gap + contact.normal.dot(centre - a.position);
  if (gap >= reach.along(contact.normal)) return;
  pbd::Manifold& m = out.emplace_back();
  m.normal = contact.normal;
  m.radius_a = radius;
  m.radius_b = contact.radius_b;
  m.count = 1;
  m.points[0] = {a.def.local.position, b.to_body(contact.on_b + (centre - b.position)), 0};
  finish_manifold(pair, key_base, m);
}

}  // namespace tandem::collision
