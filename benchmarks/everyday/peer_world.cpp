// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies of these scenes for the adapters of benchmarks/peers.
#include <Eigen/Eigenvalues>
#include <stdexcept>
#include <vector>

#include "everyday/any_world.h"

namespace tandem::everyday {
namespace {

Pose times(const Pose& a, const Pose& b) {
  return {a.to_world(b.position), a.orientation * b.orientation};
}

Pose inverse(const Pose& a) { return {a.to_local(Vec3::Zero()), a.orientation.conjugate()}; }

/// @param frame  of the body, in the shape's
struct ToPlain {
  const Pose& frame;

  bench::SceneShape operator()(const Sphere& s) const { return bench::SphereShape{s.radius}; }
  bench::SceneShape operator()(const Capsule& s) const {
    return bench::CapsuleShape{s.radius, s.half_height};
  }
  bench::SceneShape operator()(const Box& s) const { return bench::BoxShape{s.half_extents}; }
  bench::SceneShape operator()(const HalfSpace& s) const {
    return bench::PlaneShape{s.normal, s.offset};
  }
  bench::SceneShape operator()(const Cylinder& s) const {
    return bench::CylinderShape{s.radius, s.half_height};
  }
  bench::SceneShape operator()(const collision::Mesh& s) const {
    bench::MeshData mesh;
    mesh.vertices.assign(s->vertices().begin(), s->vertices().end());
    for (const auto& t : s->triangles()) mesh.triangles.push_back({t[0], t[1], t[2]});
    return std::make_shared<const bench::MeshData>(std::move(mesh));
  }
  bench::SceneShape operator()(const collision::Hull& s) const {
    std::vector<Vec3> points;
    for (const Vec3& point : s->points()) points.push_back(frame.to_local(point));
    return std::make_shared<const std::vector<Vec3>>(std::move(points));
  }
  bench::SceneShape operator()(const Cone&) const {
    throw std::invalid_argument("the adapters know no cones");
  }
  bench::SceneShape operator()(const collision::Field&) const {
    throw std::invalid_argument("the adapters know no fields of heights");
  }
};

class PeerWorld final : public AnyWorld {
 public:
  PeerWorld(const bench::MakeEngine& peer, const WorldOptions& options)
      : peer_(peer), settings_{.sleeping = options.sleeping} {
    scene_.gravity = options.gravity;
  }

  BodyId add(std::span<const collision::CompoundPart> parts, const SolidDef& def) override {
    if (parts.size() != 1) throw std::invalid_argument("the adapters know no compounds");
    if (def.linear_damping > 0.0 || def.angular_damping > 0.0) {
      throw std::invalid_argument("the adapters know no damping");
    }
    if (def.type == BodyType::Kinematic) {
      throw std::invalid_argument("the adapters know no kinematic bodies");
    }
    const collision::Shape& shape = parts.front().shape;
    bench::SceneBody body{.type = def.type, .twist = def.twist};
    Pose frame;
    if (def.type == BodyType::Dynamic) {
      const collision::MassProperties mass = mass_properties(shape, def.density);
      body.mass = mass.mass;
      body.inertia = mass.inertia.diagonal();
      // Adapters need bodies with principal axes, which a hull may lack.
      if (std::holds_alternative<collision::Hull>(shape)) {
        const Eigen::SelfAdjointEigenSolver<pbd::Mat3> principal(mass.inertia);
        pbd::Mat3 axes = principal.eigenvectors();
        if (axes.determinant() < 0.0) axes.col(0) *= -1.0;
        frame = {.position = mass.com, .orientation = Quat(axes)};
        body.inertia = principal.eigenvalues();
      }
      if (!def.can_sleep) settings_.sleeping = false;
    }
    body.shape = std::visit(ToPlain{frame}, shape);
    body.pose = times(def.pose, frame);
    body.friction = def.material.friction;
    body.restitution = def.material.restitution;
    scene_.bodies.push_back(body);
    shape_in_body_.push_back(inverse(frame));
    return {.index = static_cast<std::uint32_t>(scene_.bodies.size()) - 1};
  }
  void add_hinge(BodyId body, const Vec3& point_w, const Vec3& axis_w) override {
    scene_.add_joint(bench::JointKind::Hinge, -1, static_cast<int>(body.index), point_w).axis_w =
        axis_w;
  }
  void step(double dt) override { engine().step(dt); }
  Pose pose(BodyId body) const override {
    return times(state(body.index).pose, shape_in_body_[body.index]);
  }
  pbd::Twist twist(BodyId body) const override { return state(body.index).twist; }
  bool awake(BodyId body) const override { return engine().awake(static_cast<int>(body.index)); }
  double kinetic_energy() const override {
    double energy = 0.0;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const bench::SceneBody& body = scene_.bodies[i];
      if (body.type != BodyType::Dynamic) continue;
      const pbd::BodyState now = state(i);
      const Vec3 spin = now.pose.orientation.conjugate() * now.twist.angular;
      energy += 0.5 * body.mass * now.twist.linear.squaredNorm() +
                0.5 * spin.dot(body.inertia.cwiseProduct(spin));
    }
    return energy;
  }
  double mechanical_energy() const override {
    double energy = kinetic_energy();
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const bench::SceneBody& body = scene_.bodies[i];
      if (body.type != BodyType::Dynamic) continue;
      energy -= body.mass * scene_.gravity.dot(state(i).pose.position);
    }
    return energy;
  }

 private:
  /// Made from all added bodies on first use.
  bench::Engine& engine() const {
    if (!engine_) engine_ = peer_(scene_, settings_);
    return *engine_;
  }
  pbd::BodyState state(std::size_t body) const { return engine().state(static_cast<int>(body)); }

  bench::MakeEngine peer_;
  bench::Settings settings_;
  bench::Scene scene_;
  std::vector<Pose> shape_in_body_;
  mutable std::unique_ptr<bench::Engine> engine_;
};

}  // namespace

std::unique_ptr<AnyWorld> make_peer_world(const bench::MakeEngine& peer,
                                          const WorldOptions& options) {
  return std::make_unique<PeerWorld>(peer, options);
}

}  // namespace tandem::everyday
