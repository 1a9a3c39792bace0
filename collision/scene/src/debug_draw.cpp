// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs that draw nothing do not link it.
#include "tandem/debug_draw.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <variant>
#include <vector>

#include "tandem/pbd/contact.h"

namespace tandem {
namespace {

using pbd::Pose;
using pbd::Vec3;

constexpr int kChords = 24;            ///< of a full ring
constexpr double kNormalLength = 0.1;  ///< m
constexpr double kPlane = 10.0;        ///< m, half of a half-space's square

/// Draws in the frame of a shape.
class Pen {
 public:
  Pen(DebugDraw& out, const Pose& pose, DebugKind kind) : out_(out), pose_(pose), kind_(kind) {}

  void operator()(const collision::Sphere& ball) {
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
    for (const auto& [u, v] : {std::pair(x, y), std::pair(y, z), std::pair(z, x)}) {
      arc(Vec3::Zero(), ball.radius * u, ball.radius * v, kChords);
    }
  }
  void operator()(const collision::Capsule& capsule) {
    tube(capsule.radius, capsule.radius, capsule.half_height);
    const Vec3 top(0.0, 0.0, capsule.half_height);
    for (const Vec3& u : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())}) {
      arc(top, capsule.radius * u, capsule.radius * Vec3::UnitZ(), kChords / 2);
      arc(-top, capsule.radius * u, -capsule.radius * Vec3::UnitZ(), kChords / 2);
    }
  }
  void operator()(const collision::Cylinder& cylinder) {
    tube(cylinder.radius, cylinder.radius, cylinder.half_height);
  }
  void operator()(const collision::Cone& cone) { tube(cone.radius, 0.0, cone.half_height); }
  void operator()(const collision::Box& box) {
    const Vec3& h = box.half_extents;
    for (int axis = 0; axis < 3; ++axis) {
      for (int corner = 0; corner < 4; ++corner) {
        Vec3 from = -h;
        if ((corner & 1) != 0) from[(axis + 1) % 3] *= -1.0;
        if ((corner & 2) != 0) from[(axis + 2) % 3] *= -1.0;
        Vec3 to = from;
        to[axis] = h[axis];
        line(from, to);
      }
    }
  }
  void operator()(const collision::HalfSpace& plane) {
    Vec3 u = plane.normal.unitOrthogonal();
    Vec3 v = plane.normal.cross(u);
    const Vec3 middle = plane.offset * plane.normal;
    u *= kPlane;
    v *= kPlane;
    const Vec3 corners[] = {middle + u + v, middle - u + v, middle - u - v, middle + u - v};
    for (int i = 0; i < 4; ++i) line(corners[i], corners[(i + 1) % 4]);
    line(middle, middle + plane.normal);
  }
  void operator()(const collision::Hull& hull) {
    for (const auto& edge : hull->edges()) {
      line(hull->centre() + hull->arms()[edge.from], hull->centre() + hull->arms()[edge.to]);
    }
  }
  void operator()(const collision::Mesh& mesh) {
    triangles(*mesh, static_cast<std::uint32_t>(mesh->triangles().size()));
  }
  void operator()(const collision::Field& field) { triangles(*field, field->triangle_count()); }

 private:
  void line(const Vec3& from, const Vec3& to) {
    out_.line(pose_.to_world(from), pose_.to_world(to), kind_);
  }
  /// From middle + u through middle + v.
  void arc(const Vec3& middle, const Vec3& u, const Vec3& v, int chords) {
    const double chord = 2.0 * std::numbers::pi / kChords;
    for (int i = 0; i < chords; ++i) {
      const double a = chord * i, b = chord * (i + 1);
      line(middle + std::cos(a) * u + std::sin(a) * v, middle + std::cos(b) * u + std::sin(b) * v);
    }
  }
  void tube(double below, double above, double half_height) {
    const Vec3 top(0.0, 0.0, half_height);
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
    arc(-top, below * x, below * y, kChords);
    if (above > 0.0) arc(top, above * x, above * y, kChords);
    for (const Vec3& side : {x, y, Vec3(-x), Vec3(-y)}) {
      line(below * side - top, above * side + top);
    }
  }
  void triangles(const auto& surface, std::uint32_t count) {
    for (std::uint32_t t = 0; t < count; ++t) {
      const auto c = surface.corners(t);
      for (std::size_t k = 0; k < 3; ++k) {
        line(surface.vertex(c[k]), surface.vertex(c[(k + 1) % 3]));
      }
    }
  }

  DebugDraw& out_;
  const Pose& pose_;
  DebugKind kind_;
};

DebugKind kind_of(const pbd::World& world, const collision::ColliderDef& def) {
  if (def.sensor) return DebugKind::Sensor;
  switch (world.props(def.body).type) {
    case pbd::BodyType::Static:
      return DebugKind::Static;
    case pbd::BodyType::Kinematic:
      return DebugKind::Kinematic;
    default:
      return world.awake(def.body) ? DebugKind::Awake : DebugKind::Asleep;
  }
}

void draw_shapes(const pbd::World& world, const collision::CollisionScene& shapes, DebugDraw& out) {
  for (std::uint32_t i = 0; i < shapes.slot_count(); ++i) {
    const collision::ColliderId id = shapes.collider_at(i);
    if (!id.valid()) continue;
    const collision::ColliderDef& def = shapes.collider(id);
    const Pose& body = world.pose(def.body);
    out.shape(def.shape,
              {body.to_world(def.local.position),
               (body.orientation * def.local.orientation).normalized()},
              kind_of(world, def));
  }
}

void draw_contacts(const pbd::World& world, DebugDraw& out, double force_scale) {
  if (world.contacts() == nullptr) return;
  for (const pbd::Contact& contact : world.contacts()->contacts()) {
    const pbd::Manifold& m = contact.manifold;
    const Pose& body = world.states()[m.body_b].pose;
    for (int i = 0; i < m.count; ++i) {
      const Vec3 at = body.to_world(m.points[i].anchor_b_l) - m.radius_b * m.normal;
      out.line(at, at + kNormalLength * m.normal, DebugKind::Contact);
      const double force = contact.force[static_cast<std::size_t>(i)];
      if (force > 0.0) out.line(at, at + force_scale * force * m.normal, DebugKind::Force);
    }
  }
}

void draw_joints(const pbd::World& world, DebugDraw& out) {
  std::vector<pbd::ConstraintEdge> edges;
  for (const auto& block : world.blocks()) {
    if (block.get() != world.contacts()) block->append_edges(edges);
  }
  for (const pbd::ConstraintEdge& edge : edges) {
    if (edge.body_a == pbd::BodyId::kNone || edge.body_b == pbd::BodyId::kNone) continue;
    out.line(world.states()[edge.body_a].pose.position, world.states()[edge.body_b].pose.position,
             DebugKind::Joint);
  }
}

void draw_corrections(const pbd::World& world, DebugDraw& out) {
  for (std::uint32_t i = 0; i < world.slot_count(); ++i) {
    const pbd::BodyId body = world.body_at(i);
    if (!body.valid()) continue;
    const Vec3 moved = world.correction(body).translation;
    const Vec3& now = world.pose(body).position;
    if (!moved.isZero(0.0)) out.line(now - moved, now, DebugKind::Correction);
  }
}

}  // namespace

void DebugDraw::shape(const collision::Shape& shape, const Pose& pose, DebugKind kind) {
  std::visit(Pen(*this, pose, kind), shape);
}

void debug_draw(const pbd::World& world, const collision::CollisionScene* shapes, DebugDraw& out,
                const DebugDrawOptions& options) {
  if (options.shapes && shapes != nullptr) draw_shapes(world, *shapes, out);
  if (options.contacts) draw_contacts(world, out, options.force_scale);
  if (options.joints) draw_joints(world, out);
  if (options.corrections) draw_corrections(world, out);
}

}  // namespace tandem
