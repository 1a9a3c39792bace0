// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Box3D's scenes have the sizes and masses of its benchmark or sample of that name, but z up,
// gravity 9.81 m/s^2 and friction 0.5. Rolling resistance and springs in joints are left out, since
// not all engines have them beside friction.
#include "scenes/joint_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/doll.h"
#include "scenes/place.h"
#include "tandem/pbd/validate.h"

namespace tandem::bench {
namespace {

constexpr double kPi = std::numbers::pi;
Quat turned(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis)); }

double ball_mass(double radius) { return kWaterDensity * 4.0 / 3.0 * kPi * std::pow(radius, 3); }

void build_human(Scene& scene, int dolls) {
  add_ground(scene);
  for (int i = 0; i < dolls; ++i) add_doll(scene, place(0.0, 2.0 * i, 1.0));
}

/// Flat, `cells` squares a side, from -half to half.
void append_grid(MeshData& mesh, int cells, double half) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto row = static_cast<std::uint32_t>(cells + 1);
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      mesh.vertices.emplace_back(2.0 * half * i / cells - half, 2.0 * half * j / cells - half, 0.0);
    }
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const std::uint32_t corner =
          first + row * static_cast<std::uint32_t>(j) + static_cast<std::uint32_t>(i);
      mesh.triangles.push_back({corner, corner + 1, corner + row + 1});
      mesh.triangles.push_back({corner, corner + row + 1, corner + row});
    }
  }
}

/// About z: `sides` sections with as many corners.
void append_torus(MeshData& mesh, std::uint32_t sides, double radius, double thickness) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t i = 0; i < sides; ++i) {
    for (std::uint32_t j = 0; j < sides; ++j) {
      const double around = 2.0 * kPi * i / sides;
      const double section = 2.0 * kPi * j / sides;
      const double r = radius + thickness * std::cos(section);
      mesh.vertices.emplace_back(r * std::cos(around), r * std::sin(around),
                                 thickness * std::sin(section));
    }
  }
  const auto corner = [&](std::uint32_t i, std::uint32_t j) {
    return first + (i % sides) * sides + j % sides;
  };
  for (std::uint32_t i = 0; i < sides; ++i) {
    for (std::uint32_t j = 0; j < sides; ++j) {
      mesh.triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      mesh.triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  }
}

/// Box3D drops a row of ten groups every 0.8 s; here all fall at once.
void build_rain(Scene& scene, int groups) {
  constexpr double kCell = 15.0;
  scene.seconds = 6.0;
  auto mesh = std::make_shared<MeshData>();
  append_grid(*mesh, 8, 0.5 * kCell);
  append_torus(*mesh, 16, 0.25 * kCell, 1.0);
  const int side = static_cast<int>(std::ceil(std::sqrt(groups)));
  for (int i = 0; i < groups; ++i) {
    const Vec3 middle(kCell * (i % side), kCell * (i / side), 0.0);
    scene.add_static(MeshShape(mesh), {.position = middle});
    for (int k = 0; k < 3; ++k) add_doll(scene, {.position = middle + Vec3(0.0, 0.75 * k, 20.0)});
  }
}

/// Between two slopes of 45 degrees, one doll above the other.
void build_wedge(Scene& scene, int dolls) {
  for (const double side : {-1.0, 1.0}) {
    const Quat turn = turned(-0.25 * kPi * side, Vec3::UnitY());
    scene.add_static(BoxShape{Vec3(10.0, 10.0, 1.0)}, {turn * Vec3(10.0 * side, 0.0, -1.0), turn});
  }
  for (int i = 0; i < dolls; ++i) {
    add_doll(scene, {Vec3(0.0, 0.2 * (i % 3), 1.0 + 2.2 * i), turned(1.1 * i, Vec3::UnitZ())});
  }
}

/// Kept awake in Box3D's own.
void build_joint_grid(Scene& scene, int side) {
  constexpr double kRadius = 0.4;
  scene.seconds = 5.0;
  for (int k = 0; k < side; ++k) {
    for (int i = 0; i < side; ++i) {
      const Pose pose = place(k, 0.0, -i);
      const SphereShape ball{kRadius};
      const int body =
          i == 0 ? scene.add_static(ball, pose) : scene.add(ball, ball_mass(kRadius), pose);
      scene.bodies.back().collides = false;
      if (i == 0) continue;
      scene.add_ball(body - 1, body, pose.position + Vec3(0.0, 0.0, 0.5));
      if (k > 0) scene.add_ball(body - side, body, pose.position - Vec3(0.5, 0.0, 0.0));
    }
  }
}

void build_ball_and_chain(Scene& scene, int links) {
  constexpr double kHalf = 0.5;
  constexpr double kRadius = 0.125;
  constexpr double kBall = 2.0;
  constexpr double kFriction = 10.0;  // N m
  const Quat along_x = turned(0.5 * kPi, Vec3::UnitY());
  const double mass = kWaterDensity * kPi * kRadius * kRadius * (2.0 * kHalf + 4.0 / 3.0 * kRadius);
  for (int i = 0; i <= links; ++i) {
    const double end = 2.0 * kHalf * i;
    const int body =
        i < links
            ? scene.add(CapsuleShape{kRadius, kHalf}, mass, {Vec3(end + kHalf, 0.0, 0.0), along_x})
            : scene.add(SphereShape{kBall}, ball_mass(kBall), place(end + kBall, 0, 0));
    SceneJoint& joint = scene.add_joint(JointKind::Ball, body - 1, body, Vec3(end, 0.0, 0.0));
    joint.friction = kFriction;
    joint.touch = false;
  }
}

SceneJoint& add_hinge(Scene& scene, int a, int b, const Vec3& point, const Vec3& axis) {
  SceneJoint& hinge = scene.add_joint(JointKind::Hinge, a, b, point);
  hinge.axis_w = axis;
  hinge.touch = false;
  return hinge;
}

void drive(SceneJoint& hinge, double speed, double max_torque) {
  hinge.driven = true;
  hinge.speed = speed;
  hinge.max_torque = max_torque;
}

/// Planks as large as those of Box3D's bridge, each on four ball joints, in an arc that sags by a
/// tenth of its span; on it a car of 120 kg, driven at 1 m/s.
void build_bridge(Scene& scene, int planks) {
  constexpr double kHalf = 0.125;
  constexpr double kWide = 0.5;
  constexpr double kWood = 500.0;                                       // kg/m^3; Box3D's is 20
  constexpr double kPlank = kWood * 4.0 * kHalf * kHalf * 2.0 * kWide;  // kg
  const double turn = 0.8 / planks;                                     // rad, between planks
  const double radius = kHalf / std::tan(0.5 * turn);
  const auto on_arc = [&](double angle, double r) {
    return Vec3(r * std::sin(angle), 0.0, radius - r * std::cos(angle));
  };
  const double rim = std::hypot(radius, kHalf);  // where planks meet
  for (int i = 0; i <= planks; ++i) {
    const int body = i < planks ? static_cast<int>(scene.bodies.size()) : -1;
    if (i < planks) {
      const double angle = (i + 0.5 - 0.5 * planks) * turn;
      scene.add(BoxShape{Vec3(kHalf, kWide, kHalf)}, kPlank,
                {on_arc(angle, radius), turned(-angle, Vec3::UnitY())});
    }
    const Vec3 pivot = on_arc((i - 0.5 * planks) * turn, rim);
    for (const double side : {-kWide, kWide}) {
      // The world comes first.
      const int before = i - 1;
      SceneJoint& joint = scene.add_joint(JointKind::Ball, body < 0 ? -1 : before,
                                          body < 0 ? before : body, pivot + Vec3(0.0, side, 0.0));
      joint.touch = false;
    }
  }
  constexpr double kWheel = 0.2;
  const double axle = kHalf + kWheel + 0.01;
  const int chassis =
      scene.add(BoxShape{Vec3(0.7, 0.25, 0.1)}, 100.0, place(0.0, 0.0, axle + 0.15));
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.35, 0.35}) {
      const int wheel = scene.add(SphereShape{0.2}, 5.0, place(x, y, axle));
      SceneJoint& hinge = add_hinge(scene, chassis, wheel, Vec3(x, y, axle), Vec3::UnitY());
      if (x < 0.0) drive(hinge, 1.0 / kWheel, 50.0);
    }
  }
}

/// A jib of 20 m turns at 0.3 rad/s and swings the ball on its cable into a wall.
void build_crane(Scene& scene, int links) {
  constexpr double kJib = 20.0;
  constexpr double kHeight = 10.0;
  constexpr double kRadius = 0.75;
  add_ground(scene);
  const int jib =
      scene.add(BoxShape{Vec3(0.5 * kJib, 0.25, 0.25)}, 2000.0, place(0.5 * kJib, 0.0, kHeight));
  drive(add_hinge(scene, -1, jib, Vec3(0.0, 0.0, kHeight), Vec3::UnitZ()), 0.3, 3e5);
  const double step = 8.0 / links;  // m, a link
  int last = jib;
  for (int i = 0; i < links; ++i) {
    const double top = kHeight - step * i;
    const int link =
        scene.add(CapsuleShape{0.05, 0.5 * step - 0.05}, 5.0, place(kJib, 0.0, top - 0.5 * step));
    scene.bodies.back().collides = false;
    scene.add_ball(last, link, Vec3(kJib, 0.0, top));
    last = link;
  }
  const double end = kHeight - 8.0;
  const int ball = scene.add(SphereShape{kRadius}, 2000.0, place(kJib, 0.0, end - kRadius));
  scene.add_ball(last, ball, Vec3(kJib, 0.0, end));
  // In its way, after a third of a turn.
  const Quat turn = turned(kPi / 3.0, Vec3::UnitZ());
  for (int k = 0; k < 5; ++k) {
    for (int i = 0; i < 8; ++i) {
      scene.add(BoxShape{Vec3::Constant(0.5)}, 200.0,
                {turn * Vec3(kJib + 1.02 * (i - 3.5), 0.0, 0.5 + k), turn});
    }
  }
}

/// On two hinges each, as in Box3D, alternately left and right. They drive against their stops.
void build_doors(Scene& scene, int doors) {
  const Vec3 half(0.75, 0.1, 1.5);
  const int side = static_cast<int>(std::ceil(std::sqrt(doors)));
  for (int i = 0; i < doors; ++i) {
    const Vec3 middle(4.0 * (i % side), 4.0 * (i / side), half.z());
    const int door =
        scene.add(BoxShape{half}, 8.0 * kWaterDensity * half.prod(), {.position = middle});
    for (const double end : {-half.z(), half.z()}) {
      SceneJoint& hinge =
          add_hinge(scene, -1, door, middle + Vec3(-half.x(), 0.0, end), Vec3::UnitZ());
      if (end > 0.0) continue;
      hinge.limited = true;
      hinge.lower = -0.5 * kPi;
      hinge.upper = 0.5 * kPi;
      drive(hinge, i % 2 == 0 ? 1.0 : -1.0, 100.0);
    }
  }
}

struct Entry {
  void (*build)(Scene&, int);
  int size;
};

constexpr std::array<Entry, kJointScenes.size()> kEntries{{{build_human, 1},
                                                           {build_rain, 4},
                                                           {build_wedge, 6},
                                                           {build_joint_grid, 30},
                                                           {build_ball_and_chain, 32},
                                                           {build_bridge, 200},
                                                           {build_crane, 20},
                                                           {build_doors, 100}}};

}  // namespace

bool is_joint_scene(std::string_view name) {
  return std::find(kJointScenes.begin(), kJointScenes.end(), name) != kJointScenes.end();
}

Scene joint_scene(std::string_view name, int size) {
  for (std::size_t i = 0; i < kJointScenes.size(); ++i) {
    if (kJointScenes[i] != name) continue;
    Scene scene;
    scene.name = name;
    kEntries[i].build(scene, size > 0 ? size : kEntries[i].size);
    return scene;
  }
  pbd::detail::refuse("scene", "one of joint_scenes.h", name);
}

}  // namespace tandem::bench
