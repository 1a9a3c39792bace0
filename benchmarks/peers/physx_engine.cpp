// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// PhysX on the CPU with its defaults (4 position iterations and 1 velocity iteration, persistent
// contact manifolds, patch friction) and either solver: PGS, the default, or TGS, which the authors
// recommend. No worker threads. Like all engines here undamped, and never asleep unless asked.
#include <PxPhysicsAPI.h>

#include <cstdio>
#include <map>
#include <stdexcept>

#include "demos/engine/engine.h"

namespace tandem::bench {
namespace {

physx::PxVec3 px(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
physx::PxQuat px(const Quat& q) {
  return physx::PxQuat(static_cast<float>(q.x()), static_cast<float>(q.y()),
                       static_cast<float>(q.z()), static_cast<float>(q.w()))
      .getNormalized();
}
physx::PxTransform px(const Pose& pose) { return {px(pose.position), px(pose.orientation)}; }
Vec3 from(const physx::PxVec3& v) { return {double(v.x), double(v.y), double(v.z)}; }

/// PhysX's process-wide state. Its errors must not mix with results.
class Process final : public physx::PxErrorCallback {
 public:
  static Process& get() {
    static Process process;
    return process;
  }
  void reportError(physx::PxErrorCode::Enum, const char* message, const char*, int) override {
    std::fprintf(stderr, "physx: %s\n", message);
  }

  physx::PxDefaultAllocator allocator;
  physx::PxFoundation* foundation = nullptr;
  physx::PxPhysics* physics = nullptr;
  physx::PxDefaultCpuDispatcher* dispatcher = nullptr;

 private:
  Process() {
    foundation = PxCreateFoundation(PX_PHYSICS_VERSION, allocator, *this);
    physics = PxCreatePhysics(PX_PHYSICS_VERSION, *foundation, physx::PxTolerancesScale());
    PxInitExtensions(*physics, nullptr);
    dispatcher = physx::PxDefaultCpuDispatcherCreate(0);
  }
};

class PhysxEngine final : public Engine {
 public:
  PhysxEngine(const Scene& scene, const Settings& settings, physx::PxSolverType::Enum solver)
      : settings_(settings), solver_(solver), substeps_(settings.substeps.value_or(1)) {
    if (!scene.has_simple_joints()) throw std::invalid_argument("physx: no such joint here");
    physx::PxSceneDesc desc(physics().getTolerancesScale());
    desc.gravity = px(scene.gravity);
    desc.cpuDispatcher = Process::get().dispatcher;
    desc.filterShader = physx::PxDefaultSimulationFilterShader;
    desc.solverType = solver;
    scene_ = physics().createScene(desc);
    for (const SceneBody& body : scene.bodies) add_body(body);
    for (const SceneJoint& joint : scene.joints) add_joint(joint);
  }
  ~PhysxEngine() override {
    for (physx::PxJoint* joint : joints_) joint->release();
    for (physx::PxRigidActor* body : bodies_) body->release();
    scene_->release();
    for (const auto& [values, material] : materials_) material->release();
  }
  PhysxEngine(const PhysxEngine&) = delete;
  PhysxEngine& operator=(const PhysxEngine&) = delete;

  std::string name() const override {
    return solver_ == physx::PxSolverType::eTGS ? "physx_tgs" : "physx_pgs";
  }
  void step(double dt) override {
    const float h = static_cast<float>(dt / substeps_);
    for (int i = 0; i < substeps_; ++i) {
      scene_->simulate(h);
      scene_->fetchResults(true);
    }
  }
  pbd::BodyState state(int body) const override {
    const physx::PxRigidActor& b = *bodies_[static_cast<std::size_t>(body)];
    const physx::PxTransform t = b.getGlobalPose();
    pbd::BodyState state;
    state.pose.position = from(t.p);
    state.pose.orientation = Quat(double(t.q.w), double(t.q.x), double(t.q.y), double(t.q.z));
    state.pose.orientation.normalize();
    if (const auto* moving = b.is<physx::PxRigidDynamic>()) {
      state.twist = {from(moving->getLinearVelocity()), from(moving->getAngularVelocity())};
    }
    return state;
  }
  EngineStats stats() const override { return {.stage_s = {}, .substeps = substeps_}; }
  bool awake(int body) const override {
    const auto* moving = bodies_[static_cast<std::size_t>(body)]->is<physx::PxRigidDynamic>();
    return moving != nullptr && !moving->isSleeping();
  }
  void set_twist(int body, const Twist& twist) override {
    auto& moving = *bodies_[static_cast<std::size_t>(body)]->is<physx::PxRigidDynamic>();
    moving.setLinearVelocity(px(twist.linear));
    moving.setAngularVelocity(px(twist.angular));
  }
  void set_pose(int body, const Pose& pose) override {
    bodies_[static_cast<std::size_t>(body)]->setGlobalPose(px(pose));
  }

 private:
  static physx::PxPhysics& physics() { return *Process::get().physics; }

  struct AddShape {
    physx::PxRigidActor& body;
    const physx::PxMaterial& material;

    physx::PxShape* add(const physx::PxGeometry& geometry) const {
      return physx::PxRigidActorExt::createExclusiveShape(body, geometry, material);
    }
    template <class Other>
    physx::PxShape* operator()(const Other&) const {
      throw std::invalid_argument("physx: this adapter has neither cylinders nor hulls");
    }
    physx::PxShape* operator()(const NoShape&) const { return nullptr; }
    physx::PxShape* operator()(const BoxShape& s) const {
      return add(physx::PxBoxGeometry(px(s.half_extents)));
    }
    physx::PxShape* operator()(const SphereShape& s) const {
      return add(physx::PxSphereGeometry(static_cast<float>(s.radius)));
    }
    physx::PxShape* operator()(const CapsuleShape& s) const {
      physx::PxShape* shape = add(physx::PxCapsuleGeometry(static_cast<float>(s.radius),
                                                           static_cast<float>(s.half_height)));
      // PhysX's axis is x.
      const physx::PxQuat turn(-physx::PxHalfPi, physx::PxVec3(0.0f, 1.0f, 0.0f));
      shape->setLocalPose(physx::PxTransform(turn));
      return shape;
    }
    physx::PxShape* operator()(const PlaneShape& s) const {
      physx::PxShape* shape = add(physx::PxPlaneGeometry());
      shape->setLocalPose(physx::PxTransformFromPlaneEquation(
          physx::PxPlane(px(s.normal), -static_cast<float>(s.offset))));
      return shape;
    }
    physx::PxShape* operator()(const MeshShape& s) const {
      std::vector<physx::PxVec3> vertices;
      for (const Vec3& v : s->vertices) vertices.push_back(px(v));
      physx::PxTriangleMeshDesc desc;
      desc.points.count = static_cast<physx::PxU32>(vertices.size());
      desc.points.stride = sizeof(physx::PxVec3);
      desc.points.data = vertices.data();
      desc.triangles.count = static_cast<physx::PxU32>(s->triangles.size());
      desc.triangles.stride = sizeof(s->triangles.front());
      desc.triangles.data = s->triangles.data();
      physx::PxTriangleMesh* mesh =
          PxCreateTriangleMesh(physx::PxCookingParams(physics().getTolerancesScale()), desc,
                               physics().getPhysicsInsertionCallback());
      physx::PxShape* shape = add(physx::PxTriangleMeshGeometry(mesh));
      mesh->release();  // the shape holds a reference
      return shape;
    }
  };

  physx::PxMaterial& material(const SceneBody& body) {
    physx::PxMaterial*& found = materials_[{body.friction, body.restitution}];
    if (found == nullptr) {
      const float friction = static_cast<float>(body.friction);
      found = physics().createMaterial(friction, friction, static_cast<float>(body.restitution));
      // PhysX takes a pair's mean of friction and, by default, of restitution.
      found->setRestitutionCombineMode(physx::PxCombineMode::eMAX);
    }
    return *found;
  }

  void add_body(const SceneBody& body) {
    if (body.type == BodyType::Dynamic) {
      physx::PxRigidDynamic* made = physics().createRigidDynamic(px(body.pose));
      made->setMass(static_cast<float>(body.mass));
      made->setMassSpaceInertiaTensor(px(body.inertia));
      made->setLinearDamping(0.0f);
      made->setAngularDamping(0.0f);
      made->setLinearVelocity(px(body.twist.linear));
      made->setAngularVelocity(px(body.twist.angular));
      if (!settings_.sleeping) made->setSleepThreshold(0.0f);
      if (settings_.iterations) {
        made->setSolverIterationCounts(static_cast<physx::PxU32>(*settings_.iterations));
      }
      bodies_.push_back(made);
    } else {
      bodies_.push_back(physics().createRigidStatic(px(body.pose)));
    }
    physx::PxShape* shape = std::visit(AddShape{*bodies_.back(), material(body)}, body.shape);
    if (shape != nullptr && !body.collides) {
      shape->setFlag(physx::PxShapeFlag::eSIMULATION_SHAPE, false);
    }
    scene_->addActor(*bodies_.back());
  }

  void add_joint(const SceneJoint& joint) {
    if (joint.kind != JointKind::Ball || joint.compliance > 0.0) {
      throw std::invalid_argument("physx: this adapter has rigid ball joints only");
    }
    physx::PxRigidActor* a = joint.a < 0 ? nullptr : bodies_[static_cast<std::size_t>(joint.a)];
    joints_.push_back(physx::PxSphericalJointCreate(
        physics(), a, physx::PxTransform(px(joint.anchor_a_l)),
        bodies_[static_cast<std::size_t>(joint.b)], physx::PxTransform(px(joint.anchor_b_l))));
  }

  Settings settings_;
  physx::PxSolverType::Enum solver_;
  int substeps_;
  physx::PxScene* scene_ = nullptr;
  std::map<std::pair<double, double>, physx::PxMaterial*> materials_;
  std::vector<physx::PxRigidActor*> bodies_;
  std::vector<physx::PxJoint*> joints_;
};

}  // namespace

std::unique_ptr<Engine> make_physx_pgs(const Scene& scene, const Settings& settings) {
  return std::make_unique<PhysxEngine>(scene, settings, physx::PxSolverType::ePGS);
}

std::unique_ptr<Engine> make_physx_tgs(const Scene& scene, const Settings& settings) {
  return std::make_unique<PhysxEngine>(scene, settings, physx::PxSolverType::eTGS);
}

}  // namespace tandem::bench
