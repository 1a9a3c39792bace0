// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bullet with its defaults (10 iterations, ERP 0.2, warm start 0.85, split impulse, Dbvt, the box
// shape's own margin). Like all engines here undamped, and never asleep unless asked.
// BT_USE_DOUBLE_PRECISION selects the precision.
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "demos/engine/engine.h"

namespace tandem::bench {
namespace {

btVector3 bt(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
btTransform bt(const Pose& pose) {
  const Quat& q = pose.orientation;
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                  static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())),
                     bt(pose.position));
}
Vec3 from(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }

class BulletEngine final : public Engine {
 public:
  BulletEngine(const Scene& scene, const Settings& settings)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broad_phase_, &solver_, &configuration_),
        substeps_(settings.substeps.value_or(1)),
        sleeping_(settings.sleeping) {
    if (!scene.has_simple_joints()) throw std::invalid_argument("bullet: no such joint here");
    world_.setGravity(bt(scene.gravity));
    if (settings.iterations) world_.getSolverInfo().m_numIterations = *settings.iterations;
    for (const SceneBody& body : scene.bodies) add_body(body);
    for (const SceneJoint& joint : scene.joints) add_joint(joint);
  }
  ~BulletEngine() override {
    for (const auto& joint : joints_) world_.removeConstraint(joint.get());
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  BulletEngine(const BulletEngine&) = delete;
  BulletEngine& operator=(const BulletEngine&) = delete;

  std::string name() const override {
    return sizeof(btScalar) == sizeof(double) ? "bullet64" : "bullet32";
  }
  void step(double dt) override {
    const btScalar h = static_cast<btScalar>(dt / substeps_);
    for (int i = 0; i < substeps_; ++i) world_.stepSimulation(h, 0);
  }
  pbd::BodyState state(int body) const override {
    const btRigidBody& b = *bodies_[static_cast<std::size_t>(body)];
    const btTransform& t = b.getWorldTransform();
    const btQuaternion q = t.getRotation();
    pbd::BodyState state;
    state.pose.position = from(t.getOrigin());
    state.pose.orientation = Quat(double(q.w()), double(q.x()), double(q.y()), double(q.z()));
    state.pose.orientation.normalize();
    state.twist = {from(b.getLinearVelocity()), from(b.getAngularVelocity())};
    return state;
  }
  EngineStats stats() const override { return {.stage_s = {}, .substeps = substeps_}; }
  bool awake(int body) const override {
    return bodies_[static_cast<std::size_t>(body)]->isActive();
  }
  void set_twist(int body, const Twist& twist) override {
    btRigidBody& b = *bodies_[static_cast<std::size_t>(body)];
    b.setLinearVelocity(bt(twist.linear));
    b.setAngularVelocity(bt(twist.angular));
    b.activate(true);
  }
  void set_pose(int body, const Pose& pose) override {
    btRigidBody& b = *bodies_[static_cast<std::size_t>(body)];
    b.setWorldTransform(bt(pose));
    b.setInterpolationWorldTransform(bt(pose));
    b.activate(true);
  }
  void touching(std::vector<std::pair<int, int>>& out) const override {
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    const btDispatcher& dispatcher = dispatcher_;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(i);
      btScalar impulse = 0;
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        impulse += manifold.getContactPoint(k).getAppliedImpulse();
      }
      if (impulse > btScalar(0)) {
        out.push_back(
            std::minmax(manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()));
      }
    }
    std::sort(out.begin() + first, out.end());
    out.erase(std::unique(out.begin() + first, out.end()), out.end());
  }

 private:
  btCollisionShape* make_shape(const SceneShape& shape) {
    struct Make {
      BulletEngine& engine;
      std::unique_ptr<btCollisionShape> operator()(const NoShape&) const {
        return std::make_unique<btSphereShape>(btScalar(0.5));
      }
      std::unique_ptr<btCollisionShape> operator()(const BoxShape& s) const {
        return std::make_unique<btBoxShape>(bt(s.half_extents));
      }
      std::unique_ptr<btCollisionShape> operator()(const SphereShape& s) const {
        return std::make_unique<btSphereShape>(static_cast<btScalar>(s.radius));
      }
      std::unique_ptr<btCollisionShape> operator()(const CapsuleShape& s) const {
        return std::make_unique<btCapsuleShapeZ>(static_cast<btScalar>(s.radius),
                                                 static_cast<btScalar>(2.0 * s.half_height));
      }
      std::unique_ptr<btCollisionShape> operator()(const CylinderShape& s) const {
        return std::make_unique<btCylinderShapeZ>(bt(Vec3(s.radius, s.radius, s.half_height)));
      }
      std::unique_ptr<btCollisionShape> operator()(const HullShape& s) const {
        auto hull = std::make_unique<btConvexHullShape>();
        for (const Vec3& point : *s) hull->addPoint(bt(point), false);
        hull->recalcLocalAabb();
        return hull;
      }
      std::unique_ptr<btCollisionShape> operator()(const PlaneShape& s) const {
        return std::make_unique<btStaticPlaneShape>(bt(s.normal), static_cast<btScalar>(s.offset));
      }
      std::unique_ptr<btCollisionShape> operator()(const MeshShape& s) const {
        auto mesh = std::make_unique<btTriangleMesh>();
        for (const auto& t : s->triangles) {
          mesh->addTriangle(bt(s->vertices[t[0]]), bt(s->vertices[t[1]]), bt(s->vertices[t[2]]));
        }
        engine.meshes_.push_back(std::move(mesh));
        return std::make_unique<btBvhTriangleMeshShape>(engine.meshes_.back().get(), true);
      }
    };
    shapes_.push_back(std::visit(Make{*this}, shape));
    return shapes_.back().get();
  }

  void add_body(const SceneBody& body) {
    const bool dynamic = body.type == BodyType::Dynamic;
    btRigidBody::btRigidBodyConstructionInfo info(
        dynamic ? static_cast<btScalar>(body.mass) : btScalar(0), nullptr, make_shape(body.shape),
        dynamic ? bt(body.inertia) : btVector3(0, 0, 0));
    info.m_startWorldTransform = bt(body.pose);
    // Bullet multiplies the friction of a pair.
    info.m_friction = static_cast<btScalar>(std::sqrt(body.friction));
    info.m_restitution = static_cast<btScalar>(std::sqrt(body.restitution));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& b = *bodies_.back();
    b.setUserIndex(static_cast<int>(bodies_.size()) - 1);
    b.setDamping(0, 0);
    if (!sleeping_) b.setActivationState(DISABLE_DEACTIVATION);
    const bool touches = body.collides && !std::holds_alternative<NoShape>(body.shape);
    world_.addRigidBody(&b, touches ? 1 : 0, touches ? -1 : 0);
    if (dynamic) {
      b.setLinearVelocity(bt(body.twist.linear));
      b.setAngularVelocity(bt(body.twist.angular));
    }
  }

  void add_joint(const SceneJoint& joint) {
    joints_.push_back(joint.a < 0 ? world_joint(joint) : pair_joint(joint));
    world_.addConstraint(joints_.back().get(), true);
  }

  std::unique_ptr<btTypedConstraint> world_joint(const SceneJoint& joint) {
    btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
    switch (joint.kind) {
      case JointKind::Ball:
        refuse_compliance(joint);
        return std::make_unique<btPoint2PointConstraint>(b, bt(joint.anchor_b_l));
      case JointKind::Distance:
        return spring(joint);
      case JointKind::Hinge:
        return driven(
            joint, std::make_unique<btHingeConstraint>(b, bt(joint.anchor_b_l), axis_in(b, joint)));
      case JointKind::Slider: {
        auto slider = std::make_unique<btSliderConstraint>(b, slider_frame(b, joint), true);
        slider->setLowerLinLimit(1);  // free
        slider->setUpperLinLimit(-1);
        slider->setLowerAngLimit(0);
        slider->setUpperAngLimit(0);
        return slider;
      }
    }
    return nullptr;
  }

  std::unique_ptr<btTypedConstraint> pair_joint(const SceneJoint& joint) {
    btRigidBody& a = *bodies_[static_cast<std::size_t>(joint.a)];
    btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
    refuse_compliance(joint);
    if (joint.kind == JointKind::Ball) {
      return std::make_unique<btPoint2PointConstraint>(a, b, bt(joint.anchor_a_l),
                                                       bt(joint.anchor_b_l));
    }
    if (joint.kind == JointKind::Hinge) {
      return driven(joint, std::make_unique<btHingeConstraint>(
                               a, b, bt(joint.anchor_a_l), bt(joint.anchor_b_l), axis_in(a, joint),
                               axis_in(b, joint)));
    }
    throw std::invalid_argument("bullet: no such joint between two bodies");
  }

  static void refuse_compliance(const SceneJoint& joint) {
    if (joint.compliance > 0.0) throw std::invalid_argument("bullet: no soft ball joint");
  }

  static btVector3 axis_in(const btRigidBody& body, const SceneJoint& joint) {
    return body.getWorldTransform().getBasis().transpose() * bt(joint.axis_w);
  }

  static std::unique_ptr<btTypedConstraint> driven(const SceneJoint& joint,
                                                   std::unique_ptr<btHingeConstraint> hinge) {
    if (joint.limited) {
      hinge->setLimit(static_cast<btScalar>(joint.lower), static_cast<btScalar>(joint.upper));
    }
    if (joint.driven) hinge->enableAngularMotor(true, static_cast<btScalar>(joint.speed), 1e20f);
    return hinge;
  }

  /// x along the joint's axis.
  static btTransform slider_frame(const btRigidBody& body, const SceneJoint& joint) {
    const btQuaternion turn = shortestArcQuat(btVector3(1, 0, 0), axis_in(body, joint));
    return btTransform(turn, bt(joint.anchor_b_l));
  }

  /// A spring to the world along x; the scenes need no other.
  std::unique_ptr<btTypedConstraint> spring(const SceneJoint& joint) {
    if (joint.compliance <= 0.0) throw std::invalid_argument("bullet: no rod");
    btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
    btTransform frame = btTransform::getIdentity();
    frame.setOrigin(bt(joint.anchor_b_l));
    auto made = std::make_unique<btGeneric6DofSpring2Constraint>(b, frame);
    for (int axis = 0; axis < 6; ++axis) made->setLimit(axis, 1, -1);  // free
    made->enableSpring(0, true);
    made->setStiffness(0, static_cast<btScalar>(1.0 / joint.compliance));
    made->setDamping(0, static_cast<btScalar>(joint.damping));
    // Measured from the body's present position.
    const double now = b.getWorldTransform().getOrigin().x() - joint.anchor_a_l.x();
    made->setEquilibriumPoint(0, static_cast<btScalar>(joint.rest_length - now));
    return made;
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broad_phase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  int substeps_;
  bool sleeping_;
  std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
};

}  // namespace

std::unique_ptr<Engine> make_bullet(const Scene& scene, const Settings& settings) {
  return std::make_unique<BulletEngine>(scene, settings);
}

}  // namespace tandem::bench
