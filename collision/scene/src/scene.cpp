// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/scene.h"

#include <utility>
#include <variant>

#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

pbd::BodyDef body_of(const SolidDef& def, const collision::MassProperties& solid) {
  pbd::BodyDef body{.type = def.type,
                    .pose = def.pose,
                    .twist = def.twist,
                    .mass = solid.mass,
                    .inertia = solid.inertia,
                    .gravity_scale = def.gravity_scale,
                    .linear_damping = def.linear_damping,
                    .angular_damping = def.angular_damping,
                    .locks = def.locks,
                    .bullet = def.bullet,
                    .can_sleep = def.can_sleep,
                    .sleep_speed = def.sleep_speed,
                    .sleep_spin = def.sleep_spin,
                    .stable_id = def.stable_id,
                    .user_data = def.user_data};
  if (!solid.com.isZero(0.0)) {  // otherwise -0 would change bits
    body.pose.position = def.pose.to_world(solid.com);
    body.origin = -solid.com;
  }
  return body;
}

collision::ColliderDef surface_of(const SolidDef& def) {
  return {.material = def.material,
          .filter = def.filter,
          .sensor = def.sensor,
          .user_data = def.user_data};
}

void require_volume(const collision::Shape& shape) {
  const auto* mesh = std::get_if<collision::Mesh>(&shape);
  const bool open = mesh != nullptr && *mesh != nullptr && !(*mesh)->closed();
  if (open || std::holds_alternative<HalfSpace>(shape) ||
      std::holds_alternative<collision::Field>(shape)) {
    pbd::detail::refuse("SolidDef: type",
                        "Static or Kinematic where the shape is a half-space, a height field or an "
                        "open mesh",
                        "Dynamic");
  }
}

/// Mass properties of a body of the given shape or shapes; not computed unless it is dynamic.
template <class Matter>
collision::MassProperties weigh(const Matter& matter, const SolidDef& def) {
  if (def.type != BodyType::Dynamic) return {};
  collision::MassProperties solid;
  if constexpr (std::is_same_v<Matter, collision::Shape>) {
    require_volume(matter);
    solid = collision::mass_properties(matter, def.mass ? 1.0 : def.density);
  } else {
    for (const collision::CompoundPart& part : matter) require_volume(part.shape);
    solid = collision::mass_properties(matter);
  }
  if (def.mass) solid.inertia *= *def.mass / std::exchange(solid.mass, *def.mass);
  return solid;
}

}  // namespace

class __attribute__((visibility("hidden"))) Scene::Impl {
 public:
  explicit Impl(const SceneOptions& options)
      : shapes(options.collision),
        world({.gravity = options.gravity}),
        solver(options.solver),
        event_options(options.events) {
    std::string error;
    if (!event_options.validate(&error)) throw std::invalid_argument(error);
    world.set_contact_source(&shapes);
  }

  /// Adds a body and what `attach` gives it, which gets the body and the pose of its shapes in it.
  BodyId add(const SolidDef& def, const collision::MassProperties& solid, auto&& attach) {
    const BodyId id = world.add_body(body_of(def, solid));
    try {
      collision::ColliderDef surface = surface_of(def);
      surface.body = id;
      surface.local.position = world.props(id).origin;
      attach(surface);
    } catch (...) {
      world.remove_body(id);
      throw;
    }
    return id;
  }

  collision::CollisionScene shapes;  ///< outlives the world, which uses it
  pbd::World world;
  pbd::Solver solver;
  collision::ContactEventOptions event_options;
  std::optional<collision::ContactEvents> events;  ///< made on demand
  std::optional<collision::SceneQuery> query;      ///< made on demand
  /// World::placements() and CollisionScene::changes() that `query` has seen.
  std::pair<std::uint64_t, std::uint64_t> queried;
  double pending = 0.0;  ///< s, sum of steps too short to make
};

Scene::Scene(const SceneOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

BodyId Scene::add(const collision::Shape& shape, const SolidDef& def) {
  return impl_->add(def, weigh(shape, def), [&](collision::ColliderDef& surface) {
    surface.shape = shape;
    impl_->shapes.add(impl_->world, surface);
  });
}

BodyId Scene::add(std::span<const collision::CompoundPart> parts, const SolidDef& def) {
  if (parts.empty()) pbd::detail::refuse("Scene::add: number of parts", "at least 1", "0");
  return impl_->add(def, weigh(parts, def), [&](const collision::ColliderDef& surface) {
    collision::add_compound(impl_->shapes, impl_->world, surface, parts);
  });
}

std::int32_t Scene::new_group() { return impl_->shapes.new_group(); }

Pose Scene::pose(BodyId body) const {
  Pose pose = impl_->world.pose(body);
  const Vec3& origin = impl_->world.props(body).origin;
  if (!origin.isZero(0.0)) pose.position = pose.to_world(origin);
  return pose;
}

void Scene::set_pose(BodyId body, const Pose& pose) {
  const Vec3& origin = impl_->world.props(body).origin;
  impl_->world.set_pose(
      body, {origin.isZero(0.0) ? pose.position : pose.to_world(-origin), pose.orientation});
}

const pbd::StepReport& Scene::step(double dt) noexcept {
  const double whole = impl_->pending + dt;
  const pbd::StepReport& report = impl_->solver.step(impl_->world, dt > 0.0 ? whole : dt);
  const bool stepped = report.status != pbd::StepStatus::InvalidStep;
  if (stepped) impl_->pending = 0.0;
  if (dt > 0.0 && whole < pbd::kShortestStep) impl_->pending = whole;
  if (stepped && impl_->events) impl_->events->update(impl_->world, impl_->shapes);
  return report;
}

const collision::ContactEvents& Scene::events() {
  if (!impl_->events) {
    impl_->events.emplace(impl_->event_options).update(impl_->world, impl_->shapes);
  }
  return *impl_->events;
}

const collision::SceneQuery& Scene::query() {
  const std::pair now(impl_->world.placements(), impl_->shapes.changes());
  if (impl_->query && impl_->queried == now) return *impl_->query;
  if (!impl_->query) impl_->query.emplace();
  impl_->query->update(impl_->world, impl_->shapes);
  impl_->queried = now;
  return *impl_->query;
}

pbd::World& Scene::world() { return impl_->world; }
const pbd::World& Scene::world() const { return impl_->world; }
collision::CollisionScene& Scene::shapes() { return impl_->shapes; }
const collision::CollisionScene& Scene::shapes() const { return impl_->shapes; }
const pbd::Solver& Scene::solver() const { return impl_->solver; }

}  // namespace tandem
