// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes.h"

#include <numbers>
#include <vector>

#include "tandem/pbd/joint.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/tether.h"

namespace tandem::stability_bench {
namespace {

using pbd::Vec3;
using peers_bench::Copy;
using peers_bench::CopyBuilder;

constexpr double kEdge = 0.1;  // m
constexpr double kMass = 0.3;  // kg

pbd::BodyId cube(CopyBuilder& b, const Vec3& position, bool collides) {
  return b.box({.pose = {position, pbd::Quat::Identity()},
                .half = Vec3::Constant(0.5 * kEdge),
                .mass = kMass,
                .collides = collides});
}

Copy free_body(double apart) {
  CopyBuilder b;
  b.world().set_gravity(Vec3::Zero());
  cube(b, Vec3(apart, 0.0, 0.0), false);
  return b.done();
}

/// 3 Hz, a tenth of critical damping.
Copy spring(double apart) {
  CopyBuilder b;
  b.world().set_gravity(Vec3::Zero());
  const pbd::BodyId body = cube(b, Vec3(apart, 0.0, 0.0), false);
  const double w = 2.0 * std::numbers::pi * 3.0;
  auto& tethers = b.world().add_block<pbd::Tethers>();
  tethers.add(b.world(), {.body = body, .stiffness = kMass * w * w, .damping = 0.2 * kMass * w});
  return b.done();
}

Copy stack(double apart) {
  CopyBuilder b;
  b.wall(Vec3(0.0, 0.0, -0.5), Vec3(5.0, 5.0, 0.5));
  for (int i = 0; i < 5; ++i) cube(b, Vec3(apart, 0.0, kEdge * (i + 0.5)), true);
  return b.done();
}

/// Ten cubes side by side on the ground; a wall blocks the way of a shifted copy.
Copy row(double apart) {
  CopyBuilder b;
  b.wall(Vec3(0.0, 0.0, -0.5), Vec3(5.0, 5.0, 0.5));
  b.wall(Vec3(10.5 * kEdge + 0.51, 0.0, 0.5), Vec3(0.5, 1.0, 0.5));
  for (int i = 0; i < 10; ++i) cube(b, Vec3(kEdge * i + apart, 0.0, 0.5 * kEdge), true);
  return b.done();
}

/// Ten links that hang from a hook, rotated as a whole in one copy.
Copy chain(double apart) {
  CopyBuilder b;
  const pbd::BodyId hook = b.hook();
  std::vector<pbd::BodyId> links;
  for (int i = 0; i < 10; ++i) {
    links.push_back(cube(b, -(i + 0.5) * kEdge * Vec3::UnitZ(), false));
    const pbd::BodyId above = i > 0 ? links[links.size() - 2] : hook;
    b.joint(pbd::ball_joint_at(b.world(), above, links.back(), -i * kEdge * Vec3::UnitZ()));
  }
  // Rotated after building: the joints of both copies are the same.
  const pbd::Quat turn = pbd::exp_map(-apart / kEdge * 0.1 * Vec3::UnitY());
  for (const pbd::BodyId link : links) {
    const pbd::Pose pose = b.world().pose(link);
    b.world().set_pose(link, {turn * pose.position, turn * pose.orientation});
  }
  return b.done();
}

}  // namespace

peers_bench::Copy build(Kind kind, double apart) {
  switch (kind) {
    case Kind::Free:
      return free_body(apart);
    case Kind::Spring:
      return spring(apart);
    case Kind::Stack:
      return stack(apart);
    case Kind::Row:
      return row(apart);
    case Kind::Chain:
      break;
  }
  return chain(apart);
}

}  // namespace tandem::stability_bench
