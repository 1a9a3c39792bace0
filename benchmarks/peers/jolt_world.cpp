// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <Jolt/Jolt.h>
// Must be the first of Jolt's headers.
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/GroupFilterTable.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/CylinderShape.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/Collision/Shape/PlaneShape.h>
#include <Jolt/Physics/Collision/Shape/RotatedTranslatedShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/Constraints/SwingTwistConstraint.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "peers/jolt_world.h"

namespace tandem::bench::jolt {
namespace {

constexpr JPH::ObjectLayer kFixed = 0;
constexpr JPH::ObjectLayer kMoving = 1;
constexpr JPH::ObjectLayer kTouchesNothing = 2;

JPH::Vec3 jph(const Vector& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
JPH::Quat jph(const Rotation& q) {
  return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
          static_cast<float>(q.w)};
}
Vector from(JPH::Vec3Arg v) { return {double(v.GetX()), double(v.GetY()), double(v.GetZ())}; }

}  // namespace

/// As in Jolt's samples: static bodies in one tree, moving ones in the other.
class Layers final : public JPH::BroadPhaseLayerInterface {
 public:
  JPH::uint GetNumBroadPhaseLayers() const override { return 2; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override {
    return JPH::BroadPhaseLayer(layer == kFixed ? 0 : 1);
  }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "layer"; }
#endif
};

class LayerAndTree final : public JPH::ObjectVsBroadPhaseLayerFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer layer, JPH::BroadPhaseLayer tree) const override {
    return layer == kMoving || (layer == kFixed && tree == JPH::BroadPhaseLayer(1));
  }
};

class LayerPairs final : public JPH::ObjectLayerPairFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override {
    return a != kTouchesNothing && b != kTouchesNothing && (a == kMoving || b == kMoving);
  }
};

namespace {

/// Jolt's process-wide state.
void register_once() {
  static const bool done = [] {
    JPH::RegisterDefaultAllocator();
    JPH::Factory::sInstance = new JPH::Factory();
    JPH::RegisterTypes();
    return true;
  }();
  static_cast<void>(done);
}

/// Jolt's capsules and cylinders are along y.
JPH::ShapeRefC along_z(const JPH::Shape* shape) {
  return new JPH::RotatedTranslatedShape(
      JPH::Vec3::sZero(), JPH::Quat::sRotation(JPH::Vec3::sAxisX(), 0.5f * JPH::JPH_PI), shape);
}

/// @throws std::invalid_argument  with Jolt's message
JPH::ShapeRefC created(const JPH::ShapeSettings& settings) {
  const JPH::ShapeSettings::ShapeResult made = settings.Create();
  if (made.HasError()) throw std::invalid_argument("jolt: " + std::string(made.GetError()));
  return made.Get();
}

JPH::ShapeRefC shape_of(const Body& body) {
  const float radius = static_cast<float>(body.radius);
  switch (body.form) {
    case Form::None:
      break;
    case Form::Box: {
      const JPH::Vec3 half = jph(body.size);
      // The default rounds edges by 50 mm, more than half of a thin box.
      return new JPH::BoxShape(half, std::min(JPH::cDefaultConvexRadius, half.ReduceMin()));
    }
    case Form::Sphere:
      return new JPH::SphereShape(radius);
    case Form::Capsule:
      return along_z(new JPH::CapsuleShape(static_cast<float>(body.half), radius));
    case Form::Cylinder: {
      const float half = static_cast<float>(body.half);
      return along_z(new JPH::CylinderShape(half, radius,
                                            std::min({JPH::cDefaultConvexRadius, half, radius})));
    }
    case Form::Hull: {
      JPH::Array<JPH::Vec3> points;
      for (const Vector& v : body.vertices) points.push_back(jph(v));
      return created(JPH::ConvexHullShapeSettings(points));
    }
    case Form::Plane:
      return new JPH::PlaneShape(JPH::Plane(jph(body.size), -radius));
    case Form::Mesh: {
      JPH::VertexList vertices;
      for (const Vector& v : body.vertices) {
        vertices.emplace_back(static_cast<float>(v.x), static_cast<float>(v.y),
                              static_cast<float>(v.z));
      }
      JPH::IndexedTriangleList triangles;
      for (const auto& t : body.triangles) triangles.push_back({t[0], t[1], t[2], 0});
      return created(JPH::MeshShapeSettings(std::move(vertices), std::move(triangles)));
    }
  }
  return new JPH::SphereShape(0.5f);  // collides with nothing
}

/// Bytes of the buffer for one step: more than needed; unused pages are never touched.
std::size_t step_buffer(std::size_t bodies) { return (std::size_t{32} << 20) + (bodies << 15); }

}  // namespace

struct World::Impl {
  explicit Impl(const Options& options)
      : buffer(step_buffer(options.bodies)),
        jobs(JPH::cMaxPhysicsJobs),
        collision_steps(options.collision_steps) {
    const auto n = static_cast<JPH::uint>(options.bodies);
    system.Init(n + 16, 0, 32 * n + 1024, 16 * n + 1024, layers, layer_and_tree, layer_pairs);
    system.SetGravity(jph(options.gravity));
    JPH::PhysicsSettings settings = system.GetPhysicsSettings();
    if (options.velocity_steps > 0) {
      settings.mNumVelocitySteps = static_cast<JPH::uint>(options.velocity_steps);
    }
    settings.mAllowSleeping = options.sleeping;
    system.SetPhysicsSettings(settings);
  }
  JPH::BodyInterface& bodies() { return system.GetBodyInterfaceNoLock(); }
  /// @param i  -1: the world
  JPH::Body& body(int i) const {
    return i < 0 ? JPH::Body::sFixedToWorld : *made[static_cast<std::size_t>(i)];
  }

  Layers layers;
  LayerAndTree layer_and_tree;
  LayerPairs layer_pairs;
  JPH::TempAllocatorImpl buffer;
  JPH::JobSystemSingleThreaded jobs;
  JPH::Ref<JPH::GroupFilterTable> apart;  ///< each body the sub group of its number
  JPH::PhysicsSystem system;
  std::vector<JPH::Body*> made;
  int collision_steps;
};

World::World(const Options& options) {
  register_once();
  impl_ = std::make_unique<Impl>(options);
}

World::~World() {
  for (JPH::Constraint* constraint : impl_->system.GetConstraints()) {
    impl_->system.RemoveConstraint(constraint);
  }
  for (const JPH::Body* body : impl_->made) {
    impl_->bodies().RemoveBody(body->GetID());
    impl_->bodies().DestroyBody(body->GetID());
  }
}

void World::add(const Body& body) {
  const bool touches = body.collides && body.form != Form::None;
  JPH::BodyCreationSettings settings(
      shape_of(body), JPH::RVec3(jph(body.start.position)),
      jph(body.start.orientation).Normalized(),
      body.dynamic ? JPH::EMotionType::Dynamic : JPH::EMotionType::Static,
      !touches       ? kTouchesNothing
      : body.dynamic ? kMoving
                     : kFixed);
  // Jolt takes a pair's geometric mean of friction and the larger restitution.
  settings.mFriction = static_cast<float>(body.friction);
  settings.mRestitution = static_cast<float>(body.restitution);
  settings.mLinearDamping = 0.0f;
  settings.mAngularDamping = 0.0f;
  if (body.dynamic) {
    settings.mLinearVelocity = jph(body.start.linear);
    settings.mAngularVelocity = jph(body.start.angular);
    settings.mOverrideMassProperties = JPH::EOverrideMassProperties::MassAndInertiaProvided;
    settings.mMassPropertiesOverride.mMass = static_cast<float>(body.mass);
    settings.mMassPropertiesOverride.mInertia = JPH::Mat44::sScale(jph(body.inertia));
  }
  JPH::Body* made = impl_->bodies().CreateBody(settings);
  if (made == nullptr) throw std::invalid_argument("jolt: more bodies than were announced");
  impl_->bodies().AddBody(
      made->GetID(), body.dynamic ? JPH::EActivation::Activate : JPH::EActivation::DontActivate);
  impl_->made.push_back(made);
}

void World::add_ball(int a, const Vector& anchor_a_l, int b, const Vector& anchor_b_l) {
  JPH::PointConstraintSettings settings;
  settings.mSpace = JPH::EConstraintSpace::LocalToBodyCOM;
  settings.mPoint1 = JPH::RVec3(jph(anchor_a_l));
  settings.mPoint2 = JPH::RVec3(jph(anchor_b_l));
  impl_->system.AddConstraint(settings.Create(impl_->body(a), impl_->body(b)));
}

void World::add_hinge(const Joint& joint) {
  JPH::HingeConstraintSettings settings;
  settings.mPoint1 = settings.mPoint2 = JPH::RVec3(jph(joint.point_w));
  settings.mHingeAxis1 = settings.mHingeAxis2 = jph(joint.axis_w);
  settings.mNormalAxis1 = settings.mNormalAxis2 = jph(joint.axis_w).GetNormalizedPerpendicular();
  if (joint.limited) {
    settings.mLimitsMin = static_cast<float>(joint.lower);
    settings.mLimitsMax = static_cast<float>(joint.upper);
  }
  settings.mMaxFrictionTorque = static_cast<float>(joint.friction);
  if (joint.driven) settings.mMotorSettings.SetTorqueLimit(static_cast<float>(joint.max_torque));
  JPH::TwoBodyConstraint* made = settings.Create(impl_->body(joint.a), impl_->body(joint.b));
  impl_->system.AddConstraint(made);
  if (!joint.driven) return;
  auto* hinge = static_cast<JPH::HingeConstraint*>(made);
  hinge->SetMotorState(JPH::EMotorState::Velocity);
  hinge->SetTargetAngularVelocity(static_cast<float>(joint.speed));
}

void World::add_swing_twist(const Joint& joint) {
  JPH::SwingTwistConstraintSettings settings;
  settings.mPosition1 = settings.mPosition2 = JPH::RVec3(jph(joint.point_w));
  settings.mTwistAxis1 = settings.mTwistAxis2 = jph(joint.axis_w);
  settings.mPlaneAxis1 = settings.mPlaneAxis2 = jph(joint.axis_w).GetNormalizedPerpendicular();
  settings.mNormalHalfConeAngle = settings.mPlaneHalfConeAngle = static_cast<float>(joint.cone);
  settings.mTwistMinAngle = joint.limited ? static_cast<float>(joint.lower) : -JPH::JPH_PI;
  settings.mTwistMaxAngle = joint.limited ? static_cast<float>(joint.upper) : JPH::JPH_PI;
  settings.mMaxFrictionTorque = static_cast<float>(joint.friction);
  impl_->system.AddConstraint(settings.Create(impl_->body(joint.a), impl_->body(joint.b)));
}

void World::set_apart(int a, int b) {
  using SubGroup = JPH::CollisionGroup::SubGroupID;
  if (!impl_->apart) {
    impl_->apart = new JPH::GroupFilterTable(static_cast<JPH::uint>(impl_->made.size()));
  }
  for (const int i : {a, b}) {
    impl_->body(i).SetCollisionGroup(JPH::CollisionGroup(impl_->apart, 0, SubGroup(i)));
  }
  impl_->apart->DisableCollision(SubGroup(a), SubGroup(b));
}

void World::ready() { impl_->system.OptimizeBroadPhase(); }

void World::step(double dt) {
  const auto error = impl_->system.Update(static_cast<float>(dt), impl_->collision_steps,
                                          &impl_->buffer, &impl_->jobs);
  if (error != JPH::EPhysicsUpdateError::None) {
    throw std::runtime_error("jolt: its buffers were too small for all contacts");
  }
}

State World::state(int body) const {
  const JPH::Body& b = *impl_->made[static_cast<std::size_t>(body)];
  const JPH::Quat q = b.GetRotation();
  State state;
  state.position = from(JPH::Vec3(b.GetPosition()));
  state.orientation = {double(q.GetX()), double(q.GetY()), double(q.GetZ()), double(q.GetW())};
  if (!b.IsStatic()) {
    state.linear = from(b.GetLinearVelocity());
    state.angular = from(b.GetAngularVelocity());
  }
  return state;
}

bool World::awake(int body) const {
  return impl_->made[static_cast<std::size_t>(body)]->IsActive();
}

void World::set_pose(int body, const Vector& position, const Rotation& orientation) {
  impl_->bodies().SetPositionAndRotation(impl_->made[static_cast<std::size_t>(body)]->GetID(),
                                         JPH::RVec3(jph(position)), jph(orientation).Normalized(),
                                         JPH::EActivation::Activate);
}

void World::set_twist(int body, const Vector& linear, const Vector& angular) {
  impl_->bodies().SetLinearAndAngularVelocity(impl_->made[static_cast<std::size_t>(body)]->GetID(),
                                              jph(linear), jph(angular));
}

}  // namespace tandem::bench::jolt
