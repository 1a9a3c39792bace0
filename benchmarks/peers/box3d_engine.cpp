// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Box3D as its samples run it: four substeps, soft contacts, warm start, contact recycling,
// continuous collision with what is fixed, one thread. Never asleep unless asked and without
// damping, as all engines here.
#include <box3d/box3d.h>
#include <box3d/collision.h>

#include <stdexcept>

#include "demos/engine/engine.h"

namespace tandem::bench {
namespace {

constexpr int kSamplesSubsteps = 4;
/// m, half the size of the slab that stands for a plane, which Box3D has not.
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
    b3WorldDef def = b3DefaultWorldDef();
    def.gravity = b3(scene.gravity);
    def.enableSleep = settings.sleeping;
    world_ = b3CreateWorld(&def);
    const b3BodyDef fixed = b3DefaultBodyDef();
    fixed_ = b3CreateBody(world_, &fixed);
    for (const SceneBody& body : scene.bodies) add_body(body);
    for (const SceneJoint& joint : scene.joints) add_joint(joint);
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
    // Of a pair Box3D takes the geometric mean of friction, the larger restitution.
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
    if (joint.kind != JointKind::Ball || joint.compliance > 0.0) {
      throw std::invalid_argument("box3d: this adapter has rigid ball joints only");
    }
    b3SphericalJointDef def = b3DefaultSphericalJointDef();
    def.base.bodyIdA = id(joint.a);
    def.base.bodyIdB = id(joint.b);
    def.base.localFrameA.p = b3(joint.anchor_a_l);
    def.base.localFrameB.p = b3(joint.anchor_b_l);
    b3CreateSphericalJoint(world_, &def);
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
