// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Invalid input is refused with a message that names field and value.
#include <limits>
#include <stdexcept>

#include "numerics/case.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace tandem::bench {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct World {
  pbd::World bodies;
  collision::CollisionScene shapes;
};

struct Refusal {
  const char* what;
  const char* field;  ///< must be in the message
  const char* value;  ///< must be in the message
  void (*ask)(World&);
};

void add_shape(World& world, const collision::Shape& shape) {
  const auto body = world.bodies.add_body({});
  world.shapes.add(world.bodies, {.body = body, .shape = shape});
}

void add_mass(World& world, double mass) { world.bodies.add_body({.mass = mass}); }

/// A cube of triangles that face inwards.
collision::Mesh inverted_cube() {
  std::vector<Vec3> v;
  for (int i = 0; i < 8; ++i) v.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const std::vector<collision::TriangleMesh::Triangle> t{
      {0, 3, 2}, {0, 1, 3}, {4, 7, 5}, {4, 6, 7}, {0, 5, 1}, {0, 4, 5},
      {2, 3, 7}, {2, 7, 6}, {0, 6, 4}, {0, 2, 6}, {1, 5, 7}, {1, 7, 3}};
  return collision::TriangleMesh::make(v, t);
}

const Refusal kRefusals[] = {
    {"box of no height", "half_extents", "0",
     [](World& w) { add_shape(w, collision::Box{Vec3(1.0, 1.0, 0.0)}); }},
    {"box turned inside out", "half_extents", "-1",
     [](World& w) { add_shape(w, collision::Box{Vec3(1.0, -1.0, 1.0)}); }},
    {"ball of no size", "radius", "0", [](World& w) { add_shape(w, collision::Sphere{0.0}); }},
    {"ball of negative size", "radius", "-1",
     [](World& w) { add_shape(w, collision::Sphere{-1.0}); }},
    {"ball of size NaN", "radius", "nan", [](World& w) { add_shape(w, collision::Sphere{kNan}); }},
    {"capsule of no length", "half_height", "0",
     [](World& w) {
       add_shape(w, collision::Capsule{0.5, 0.0});
     }},
    {"half-space without a normal", "normal", "0",
     [](World& w) {
       add_shape(w, collision::HalfSpace{Vec3::Zero(), 0.0});
     }},
    {"mass of an inverted mesh", "volume of the mesh", "-1",
     [](World&) { (void)collision::mass_properties(inverted_cube(), 1000.0); }},
    {"mesh with a corner at NaN", "vertices", "nan",
     [](World&) {
       const std::vector<Vec3> v{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, kNan, 0)};
       const std::vector<collision::TriangleMesh::Triangle> t{{0, 1, 2}};
       (void)collision::TriangleMesh::make(v, t);
     }},
    {"triangle without area", "triangle", "0",
     [](World&) {
       const std::vector<Vec3> v{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
       const std::vector<collision::TriangleMesh::Triangle> t{{0, 1, 2}};
       (void)collision::TriangleMesh::make(v, t);
     }},
    {"density of zero", "density", "0",
     [](World&) { (void)collision::mass_properties(collision::Box{}, 0.0); }},
    {"body without mass", "mass", "0", [](World& w) { add_mass(w, 0.0); }},
    {"body of negative mass", "mass", "-1", [](World& w) { add_mass(w, -1.0); }},
    {"body of mass NaN", "mass", "nan", [](World& w) { add_mass(w, kNan); }},
    {"body without inertia", "inertia", "",
     [](World& w) { w.bodies.add_body({.inertia = pbd::Mat3::Zero()}); }},
    {"body of negative inertia", "inertia", "",
     [](World& w) { w.bodies.add_body({.inertia = -pbd::Mat3::Identity()}); }},
    {"body at NaN", "position", "nan",
     [](World& w) { w.bodies.add_body({.pose = {.position = Vec3(kNan, 0.0, 0.0)}}); }},
    {"body moved to NaN", "position", "nan",
     [](World& w) {
       const auto body = w.bodies.add_body({});
       w.bodies.set_pose(body, {.position = Vec3(0.0, kNan, 0.0)});
     }},
    {"speed of NaN", "linear", "nan",
     [](World& w) {
       const auto body = w.bodies.add_body({});
       w.bodies.set_twist(body, {.linear = Vec3(0.0, kNan, 0.0)});
     }},
    {"gravity of NaN", "gravity", "nan",
     [](World& w) { w.bodies.set_gravity(Vec3(0.0, 0.0, kNan)); }},
    {"friction below zero", "friction", "-1",
     [](World& w) {
       const auto body = w.bodies.add_body({});
       w.shapes.add(w.bodies,
                    {.body = body, .shape = collision::Sphere{}, .material = {.friction = -1.0}});
     }},
    {"joint with an anchor at NaN", "anchor", "nan",
     [](World& w) {
       const auto body = w.bodies.add_body({});
       auto& balls = w.bodies.add_block<pbd::JointBlock>();
       balls.add(w.bodies, pbd::BallJointDef{.b = body, .frame_b = {Vec3(kNan, 0.0, 0.0)}});
     }},
    {"joint of negative compliance", "compliance", "-1",
     [](World& w) {
       const auto body = w.bodies.add_body({});
       auto& balls = w.bodies.add_block<pbd::JointBlock>();
       balls.add(w.bodies, pbd::BallJointDef{.b = body, .compliance = -1.0});
     }},
    {"solver without substeps", "substeps", "0",
     [](World&) { (void)pbd::Solver({.substeps = 0}); }},
};

void refused(Sheet& sheet) {
  for (const Refusal& refusal : kRefusals) {
    World world;
    double named = 0.0;
    try {
      refusal.ask(world);
    } catch (const std::invalid_argument& error) {
      const std::string_view message = error.what();
      named = message.find(refusal.field) != std::string_view::npos &&
                      message.find(refusal.value) != std::string_view::npos
                  ? 1.0
                  : 0.5;
    }
    sheet.at_least(refusal.what, named, 1.0, "", "1: refused by name; 0.5: not named; 0: taken");
  }
}

void step_of_nan(Sheet& sheet) {
  pbd::World world;
  world.add_body({});
  pbd::Solver solver;
  const std::uint64_t before = world.hash();
  for (const double dt : {kNan, 0.0, -1.0}) (void)solver.step(world, dt);
  sheet.at_least("world unchanged", world.hash() == before ? 1.0 : 0.0, 1.0, "", "refused");
}

}  // namespace

std::vector<Case> refusal_cases() {
  const std::string family = "extreme";
  return {
      {family, "bad input", refused, true},
      {family, "steps of NaN, 0 and -1 s", step_of_nan, true},
  };
}

}  // namespace tandem::bench
