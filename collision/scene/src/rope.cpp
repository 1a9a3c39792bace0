// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without ropes do not link it.
#include "tandem/rope.h"

#include <cmath>

#include "add_whole.h"
#include "particle.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

constexpr std::string_view kKind = "RopeDef";
constexpr int kMaxParticles = 100'000;

void check(const RopeDef& def) {
  using pbd::detail::require;
  pbd::detail::require_finite(def.from, kKind, "from");
  pbd::detail::require_finite(def.to, kKind, "to");
  const double distance = (def.to - def.from).norm();
  const double length = def.length.value_or(distance);
  require(length > 0.0 && length >= distance && std::isfinite(length), kKind, "length", length,
          "above 0 and at least the distance of its ends");
  require(def.particles >= 2 && def.particles <= kMaxParticles, kKind, "particles", def.particles,
          "from 2 to 100000");
  require(length == distance || def.particles % 2 == 1, kKind, "particles", def.particles,
          "odd where the rope is longer than the distance of its ends");
  require(def.mass > 0.0 && std::isfinite(def.mass), kKind, "mass", def.mass, "finite and > 0");
  require(def.bending >= 0.0 && std::isfinite(def.bending), kKind, "bending", def.bending,
          "finite and >= 0");
}

/// Initial lowest point: half a length from both ends.
Vec3 lowest(const RopeDef& def, double length, const Vec3& gravity) {
  const Vec3 middle = 0.5 * (def.from + def.to);
  const Vec3 along = def.to - def.from;
  Vec3 down = gravity.isZero(0.0) ? Vec3(-Vec3::UnitZ()) : Vec3(gravity.normalized());
  if (along.norm() > 0.0) {
    const Vec3 n = along.normalized();
    down -= down.dot(n) * n;
    // A vertical rope bulges to its side.
    if (down.norm() < 1e-6) down = n.unitOrthogonal();
    down.normalize();
  }
  const double sag2 = 0.25 * (length * length - along.squaredNorm());
  return middle + std::sqrt(std::max(0.0, sag2)) * down;
}

}  // namespace

Rope::Rope(Scene& scene, const RopeDef& def) : world_(&scene.world()), shapes_(&scene.shapes()) {
  check(def);
  detail::ParticleKind kind{def.radius, def.damping, def.material, def.filter};
  detail::check(kind, kKind);
  if (kind.filter.group == 0) kind.filter.group = scene.new_group();
  detail::add_whole(scene, particles_, [&] {
    const double distance = (def.to - def.from).norm();
    const double length = def.length.value_or(distance);
    const Vec3 middle = lowest(def, length, world_->gravity());
    const int pieces = def.particles - 1;
    const double piece = length / pieces;
    for (int i = 0; i <= pieces; ++i) {
      const double t = 2.0 * i / pieces;
      Vec3 at = def.from + 0.5 * t * (def.to - def.from);
      if (length > distance) {
        at = t <= 1.0 ? Vec3(def.from + t * (middle - def.from))
                      : Vec3(middle + (t - 1.0) * (def.to - middle));
      }
      const double share = i == 0 || i == pieces ? 0.5 : 1.0;
      particles_.push_back(detail::add_particle(scene, kind, at, share * def.mass / pieces));
    }
    detail::cloth_of(*world_).add(
        *world_, pbd::StrandDef{.points = particles_,
                                .lengths = std::vector<double>(particles_.size() - 1, piece),
                                .compliance = def.compliance});
    if (def.bending == 0.0) return;
    for (std::size_t i = 2; i < particles_.size(); ++i) {
      detail::add_bending(*world_, particles_[i - 2], particles_[i - 1], particles_[i],
                          def.bending / (piece * piece * piece));
    }
  });
}

pbd::ClothRowId Rope::attach(std::size_t particle, BodyId host) {
  pbd::detail::require(particle < particles_.size(), "Rope::attach", "particle",
                       static_cast<double>(particle), "below particles().size()");
  return detail::attach(*world_, *shapes_, particles_[particle], host);
}

}  // namespace tandem
