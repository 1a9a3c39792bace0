// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Box3D as its samples run it: four substeps, soft contacts, warm start, contact recycling,
// continuous collision with static bodies, its own workers. Like all engines here undamped, and
// never asleep unless asked.
#include <box3d/box3d.h>
#include <box3d/collision.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "demos/engine/engine.h"

namespace tandem::bench {
namespace {

constexpr int kSamplesSubsteps = 4;
/// m, half extent of the slab that replaces a plane, which Box3D lacks.
constexpr float kPlaneHalf = 200.0f;

b3Vec3 b3(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
b3Pos b3_place(const Vec3& v) {
  b3Pos place{};
  place.x = static_cast<decltype(place.x)>(v.x());
  place.y = static_cast<decltype(place.y)>(v.y());
  place.z = static_cast<decltype(place.z)>(v.z());
  return place;
}
b3Quat b3(const Quat& q) { return {b3(Vec3(q.vec())), static_cast<float>(q.w())}; }
template <class Vector>
Vec3 from(const Vector& v) {
  return {double(v.x), double(v.y), double(v.z)};
}

class Box3dEngine final : public Engine {
 public:
  Box3dEngine(const Scene& scene, const Settings& settings)
      : substeps_(settings.substeps.value_or(kSamplesSubsteps)) {
    // Its messages, such as refused hulls, must not mix with results.
    b3SetLogFcn([](const char* message) { std::fprintf(stderr, "box3d: %s\n", message); });
    b3WorldDef def = b3DefaultWorldDef();
    def.gravity = b3(scene.gravity);
    def.enableSleep = settings.sleeping;
    def.workerCount = static_cast<std::uint32_t>(settings.threads);
    world_ = b3CreateWorld(&def);
    const b3BodyDef fixed = b3DefaultBodyDef();
    fixed_ = b3CreateBody(world_, &fixed);
    for (const SceneBody& body : scene.bodies) add_body(body);
    for (const SceneJoint& joint : scene.joints) add_joint(joint);
    for (const auto& [a, b] : scene.apart) set_apart(a, b);
  }
  ~Box3dEngine() override {
    b3DestroyWorld(world_);
    for (b3MeshData* mesh : meshes_) b3DestroyMesh(mesh);
  }
  Box3dEngine(const Box3dEngine&) = delete;
  Box3dEngine& operator=(const Box3dEngine&) = delete;

  std::string name() const override { return "box3d"; }
  void step(double dt) override { b3World_Step(world_, static_cast<float>(dt), substeps_); }
  pbd::BodyState state(int body) const override {
    const b3BodyId b = id(body);
    const b3Quat q = b3Body_GetRotation(b);
    pbd::BodyState state;
    state.pose.position = from(b3Body_GetPosition(b));
    state.pose.orientation = Quat(double(q.s), double(q.v.x), double(q.v.y), double(q.v.z));
    state.pose.orientation.normalize();
    state.twist = {from(b3Body_GetLinearVelocity(b)), from(b3Body_GetAngularVelocity(b))};
    return state;
  }
  EngineStats stats() const override { return {.stage_s = {}, .substeps = substeps_}; }
  bool awake(int body) const override { return b3Body_IsAwake(id(body)); }
  void set_twist(int body, const Twist& twist) override {
    b3Body_SetLinearVelocity(id(body), b3(twist.linear));
    b3Body_SetAngularVelocity(id(body), b3(twist.angular));
    b3Body_SetAwake(id(body), true);
  }
  void set_pose(int body, const Pose& pose) override {
    b3Body_SetTransform(id(body), b3_place(pose.position), b3(pose.orientation));
    b3Body_SetAwake(id(body), true);
  }

 private:
  struct AddShape {
    Box3dEngine& engine;
    b3BodyId body;
    const b3ShapeDef& def;

    void operator()(const NoShape&) const {}
    void operator()(const BoxShape& s) const {
      const b3Vec3 half = b3(s.half_extents);
      const b3BoxHull hull = b3MakeBoxHull(half.x, half.y, half.z);
      b3CreateHullShape(body, &def, &hull.base);
    }
    void operator()(const SphereShape& s) const {
      const b3Sphere sphere{{0.0f, 0.0f, 0.0f}, static_cast<float>(s.radius)};
      b3CreateSphereShape(body, &def, &sphere);
    }
    void operator()(const CapsuleShape& s) const {
      const float half = static_cast<float>(s.half_height);
      const b3Capsule capsule{
          {0.0f, 0.0f, -half}, {0.0f, 0.0f, half}, static_cast<float>(s.radius)};
      b3CreateCapsuleShape(body, &def, &capsule);
    }
    /// A prism of 24 sides: Box3D has no cylinder.
    void operator()(const CylinderShape& s) const {
      std::vector<Vec3> corners;
      for (int i = 0; i < 24; ++i) {
        const double turn = 2.0 * std::numbers::pi * i / 24.0;
        for (const double z : {-s.half_height, s.half_height}) {
          corners.emplace_back(s.radius * std::cos(turn), s.radius * std::sin(turn), z);
        }
      }
      add_hull(corners);
    }
    void operator()(const HullShape& s) const { add_hull(*s); }
    void operator()(const PlaneShape& s) const {
      b3Transform slab{};
      slab.p = b3(s.normal * (s.offset - 1.0));
      slab.q = b3(Quat(Quat::FromTwoVectors(Vec3::UnitZ(), s.normal)));
      const b3BoxHull hull = b3MakeTransformedBoxHull(kPlaneHalf, kPlaneHalf, 1.0f, slab);
      b3CreateHullShape(body, &def, &hull.base);
    }
    void operator()(const MeshShape& s) const {
      std::vector<b3Vec3> vertices;
      for (const Vec3& v : s->vertices) vertices.push_back(b3(v));
      std::vector<std::int32_t> indices;
      for (const auto& triangle : s->triangles) {
        for (const std::uint32_t i : triangle) indices.push_back(static_cast<std::int32_t>(i));
      }
      b3MeshDef mesh{};
      mesh.vertices = vertices.data();
      mesh.vertexCount = static_cast<int>(vertices.size());
      mesh.indices = indices.data();
      mesh.triangleCount = static_cast<int>(s->triangles.size());
      mesh.identifyEdges = true;
      engine.meshes_.push_back(b3CreateMesh(&mesh, nullptr, 0));
      b3CreateMeshShape(body, &def, engine.meshes_.back(), {1.0f, 1.0f, 1.0f});
    }
    void add_hull(const std::vector<Vec3>& corners) const {
      std::vector<b3Vec3> points;
      for (const Vec3& corner : corners) points.push_back(b3(corner));
      const int count = static_cast<int>(points.size());
      b3HullData* hull = b3CreateHull(points.data(), count, count);
      // It refuses more than 128 edges; a hull of 44 corners has fewer.
      if (hull == nullptr) hull = b3CreateHull(points.data(), count, 44);
      if (hull == nullptr) throw std::invalid_argument("box3d: it refuses this hull");
      b3CreateHullShape(body, &def, hull);
      b3DestroyHull(hull);
    }
  };

  b3BodyId id(int body) const {
    return body < 0 ? fixed_ : bodies_[static_cast<std::size_t>(body)];
  }

  void add_body(const SceneBody& body) {
    const bool dynamic = body.type == BodyType::Dynamic;
    b3BodyDef def = b3DefaultBodyDef();
    def.type = dynamic ? b3_dynamicBody : b3_staticBody;
    def.position = b3_place(body.pose.position);
    def.rotation = b3(body.pose.orientation);
    if (dynamic) {
      def.linearVelocity = b3(body.twist.linear);
      def.angularVelocity = b3(body.twist.angular);
    }
    const b3BodyId made = b3CreateBody(world_, &def);
    bodies_.push_back(made);
    b3ShapeDef shape = b3DefaultShapeDef();
    // Box3D takes a pair's geometric mean of friction and the larger restitution.
    shape.baseMaterial.friction = static_cast<float>(body.friction);
    shape.baseMaterial.restitution = static_cast<float>(body.restitution);
    if (!body.collides) shape.filter = {.categoryBits = 0, .maskBits = 0, .groupIndex = 0};
    std::visit(AddShape{*this, made, shape}, body.shape);
    if (!dynamic) return;
    const b3Vec3 inertia = b3(body.inertia);
    b3MassData mass{};
    mass.mass = static_cast<float>(body.mass);
    mass.inertia.cx.x = inertia.x;
    mass.inertia.cy.y = inertia.y;
    mass.inertia.cz.z = inertia.z;
    b3Body_SetMassData(made, mass);
  }

  void add_joint(const SceneJoint& joint) {
    // An unbounded drive has no value in its floats.
    if (joint.driven && !std::isfinite(joint.max_torque)) {
      throw std::invalid_argument("box3d: no motor of unlimited torque");
    }
    if (joint.kind == JointKind::Hinge) return add_hinge(joint);
    if (joint.kind != JointKind::Ball || joint.compliance > 0.0) {
      throw std::invalid_argument("box3d: this adapter has rigid ball joints and hinges only");
    }
    b3SphericalJointDef def = b3DefaultSphericalJointDef();
    set_base(def.base, joint);
    def.enableConeLimit = std::isfinite(joint.cone);
    if (def.enableConeLimit) def.coneAngle = static_cast<float>(joint.cone);
    def.enableTwistLimit = joint.limited;
    def.lowerTwistAngle = static_cast<float>(joint.lower);
    def.upperTwistAngle = static_cast<float>(joint.upper);
    // Its samples make friction of a motor with speed 0.
    def.enableMotor = joint.friction > 0.0;
    def.maxMotorTorque = static_cast<float>(joint.friction);
    b3CreateSphericalJoint(world_, &def);
  }

  void add_hinge(const SceneJoint& joint) {
    b3RevoluteJointDef def = b3DefaultRevoluteJointDef();
    set_base(def.base, joint);
    def.enableLimit = joint.limited;
    def.lowerAngle = static_cast<float>(joint.lower);
    def.upperAngle = static_cast<float>(joint.upper);
    def.enableMotor = joint.driven || joint.friction > 0.0;
    def.motorSpeed = static_cast<float>(joint.driven ? joint.speed : 0.0);
    def.maxMotorTorque = static_cast<float>(joint.driven ? joint.max_torque : joint.friction);
    b3CreateRevoluteJoint(world_, &def);
  }

  /// Its joints turn and twist about z of their frames.
  void set_base(b3JointDef& base, const SceneJoint& joint) const {
    const Quat frame_w = Quat::FromTwoVectors(Vec3::UnitZ(), joint.axis_w);
    const auto local = [&](int body, const Vec3& anchor_l) {
      b3Transform frame{};
      frame.p = b3(anchor_l);
      const Quat turn = body < 0 ? Quat(Quat::Identity()) : state(body).pose.orientation;
      frame.q = b3(Quat(turn.conjugate() * frame_w));
      return frame;
    };
    base.bodyIdA = id(joint.a);
    base.bodyIdB = id(joint.b);
    base.localFrameA = local(joint.a, joint.anchor_a_l);
    base.localFrameB = local(joint.b, joint.anchor_b_l);
    base.collideConnected = joint.touch;
  }

  void set_apart(int a, int b) {
    b3FilterJointDef def = b3DefaultFilterJointDef();
    def.base.bodyIdA = id(a);
    def.base.bodyIdB = id(b);
    b3CreateFilterJoint(world_, &def);
  }

  int substeps_;
  b3WorldId world_{};
  b3BodyId fixed_{};  ///< holds joints to the world
  std::vector<b3BodyId> bodies_;
  std::vector<b3MeshData*> meshes_;
};

}  // namespace

std::unique_ptr<Engine> make_box3d(const Scene& scene, const Settings& settings) {
  return std::make_unique<Box3dEngine>(scene, settings);
}

}  // namespace tandem::bench
