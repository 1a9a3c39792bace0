// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

#include <algorithm>

#include "demos/engine/engine.h"
#include "engine/tandem_joints.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/solver.h"

namespace tandem::bench {
namespace {

struct ToShape {
  collision::Shape operator()(const NoShape&) const { return collision::Sphere{}; }
  collision::Shape operator()(const BoxShape& s) const { return collision::Box{s.half_extents}; }
  collision::Shape operator()(const SphereShape& s) const { return collision::Sphere{s.radius}; }
  collision::Shape operator()(const CapsuleShape& s) const {
    return collision::Capsule{s.radius, s.half_height};
  }
  collision::Shape operator()(const PlaneShape& s) const {
    return collision::HalfSpace{s.normal, s.offset};
  }
  collision::Shape operator()(const CylinderShape& s) const {
    return collision::Cylinder{s.radius, s.half_height};
  }
  collision::Shape operator()(const MeshShape& s) const {
    return collision::TriangleMesh::make(s->vertices, s->triangles);
  }
  collision::Shape operator()(const HullShape& s) const { return collision::ConvexHull::make(*s); }
};

pbd::SolverOptions solver_options(const Settings& settings) {
  pbd::SolverOptions options;
  if (settings.substeps) options.substeps = *settings.substeps;
  if (settings.iterations) options.position_iterations = *settings.iterations;
  if (settings.velocity_iterations) options.velocity_iterations = *settings.velocity_iterations;
  options.threads = settings.threads;
  if (!settings.sleeping) options.sleep_after = 0.0;
  return options;
}

collision::CollisionOptions collision_options(const Settings& settings) {
  collision::CollisionOptions options;
  if (!settings.recycling) options.recycle_distance = 0.0;
  return options;
}

class TandemEngine final : public Engine {
 public:
  TandemEngine(const Scene& scene, const Settings& settings)
      : world_({.gravity = scene.gravity}),
        shapes_(collision_options(settings)),
        solver_(solver_options(settings)) {
    bool touches = false;
    for (const SceneBody& body : scene.bodies) {
      add_body(body);
      touches |= body.collides && !std::holds_alternative<NoShape>(body.shape);
    }
    if (touches) world_.set_contact_source(&shapes_);
    add_joints(world_, scene, ids_);
    for (const auto& [a, b] : scene.apart) shapes_.set_apart(world_, id(a), id(b));
  }

  std::string name() const override { return "tandem"; }
  void step(double dt) override { report_ = &solver_.step(world_, dt); }
  pbd::BodyState state(int body) const override { return world_.state(id(body)); }
  bool awake(int body) const override { return world_.awake(id(body)); }
  void set_twist(int body, const Twist& twist) override { world_.set_twist(id(body), twist); }
  void set_pose(int body, const Pose& pose) override { world_.set_pose(id(body), pose); }
  void touching(std::vector<std::pair<int, int>>& out) const override {
    if (world_.contacts() == nullptr) return;
    const auto number = [&](std::uint32_t slot) {
      const auto found = std::find_if(ids_.begin(), ids_.end(),
                                      [slot](const pbd::BodyId& i) { return i.index == slot; });
      return static_cast<int>(found - ids_.begin());
    };
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    for (const pbd::Contact& contact : world_.contacts()->contacts()) {
      if (!(contact.impulse > 0.0)) continue;
      out.push_back(std::minmax(number(contact.manifold.body_a), number(contact.manifold.body_b)));
    }
    std::sort(out.begin() + first, out.end());
    out.erase(std::unique(out.begin() + first, out.end()), out.end());
  }
  EngineStats stats() const override {
    EngineStats stats{.stage_s = {}, .substeps = solver_.options().substeps};
    if (report_ == nullptr) return stats;
    stats.substeps = report_->substeps;
    stats.failed = report_->status != pbd::StepStatus::Ok;
    for (std::size_t i = 0; i < pbd::kStageNames.size(); ++i) {
      stats.stage_s.emplace_back(std::string(pbd::kStageNames[i]), report_->stage_s[i]);
    }
    return stats;
  }

 private:
  pbd::BodyId id(int body) const {
    return body < 0 ? pbd::BodyId{} : ids_[static_cast<std::size_t>(body)];
  }

  void add_body(const SceneBody& body) {
    pbd::BodyDef def{.type = body.type, .pose = body.pose, .twist = body.twist};
    if (body.type == BodyType::Dynamic) {
      def.mass = body.mass;
      def.inertia = body.inertia.asDiagonal();
    }
    if (body.limb) {  // as in tandem::Ragdoll
      def.sleep_speed = 0.03;
      def.sleep_spin = 0.3;
    }
    ids_.push_back(world_.add_body(def));
    if (!body.collides || std::holds_alternative<NoShape>(body.shape)) return;
    shapes_.add(world_, {.body = ids_.back(),
                         .shape = std::visit(ToShape{}, body.shape),
                         .material = {.friction = body.friction, .restitution = body.restitution}});
  }

  pbd::World world_;
  collision::CollisionScene shapes_;
  pbd::Solver solver_;
  std::vector<pbd::BodyId> ids_;
  const pbd::StepReport* report_ = nullptr;
};

}  // namespace

std::unique_ptr<Engine> make_tandem(const Scene& scene, const Settings& settings) {
  return std::make_unique<TandemEngine>(scene, settings);
}

}  // namespace tandem::bench
