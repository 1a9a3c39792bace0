// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <vector>

#include "fixture.h"
#include "tandem/pbd/bytes.h"

namespace tandem::collision::testing {

inline Hull cube_hull(double half) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back((i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half,
                        (i & 4) != 0 ? half : -half);
  }
  return ConvexHull::make(points);
}

/// One of each kind, about `scale` large. m
inline std::vector<Shape> convex_shapes(double scale) {
  return {Sphere{0.5 * scale},
          Capsule{0.3 * scale, 0.4 * scale},
          Box{scale * Vec3(0.4, 0.5, 0.3)},
          Cylinder{0.4 * scale, 0.5 * scale},
          Cone{0.5 * scale, 0.6 * scale},
          cube_hull(0.4 * scale)};
}

/// Every bit of the manifolds.
inline std::vector<std::byte> bytes_of(const std::vector<Manifold>& manifolds) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  for (const Manifold& m : manifolds) {
    out.u64(m.key);
    out.u32(m.body_a);
    out.u32(m.body_b);
    out.vec3(m.normal);
    out.f64(m.radius_a);
    out.f64(m.radius_b);
    out.f64(m.friction);
    out.f64(m.restitution);
    for (int i = 0; i < m.count; ++i) {
      out.vec3(m.points[i].anchor_a_l);
      out.vec3(m.points[i].anchor_b_l);
      out.u32(m.points[i].feature);
    }
  }
  return bytes;
}

/// Many kinds of bodies falling onto a floor of the given kind.
inline void fill(Fixture& f, const Shape& ground, int count, std::uint64_t seed) {
  f.fixed(ground);
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const Shape shape = i % 3 == 0   ? Shape(Sphere{0.2})
                        : i % 3 == 1 ? Shape(Box{Vec3(0.2, 0.25, 0.15)})
                                     : Shape(Capsule{0.15, 0.2});
    const Vec3 p = random.vec(1.0) + Vec3(0, 0, 1.5 + 0.1 * i);
    f.add(shape, {p, random.quat()});
  }
  f.world.set_contact_source(&f.scene);
}

}  // namespace tandem::collision::testing
