// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without ragdolls do not link it.
#include "tandem/ragdoll.h"

#include <cmath>
#include <vector>

#include "add_whole.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

using Part = Ragdoll::Part;

/// Shares of height, except angles (rad) and the share of mass. Describes the left side; the right
/// one is its mirror image.
struct Limb {
  double mass = 0.0;
  double side = 0.0;    ///< of its centre, to the left
  double top = 0.0;     ///< above the ground
  double bottom = 0.0;  ///< above the ground
  double radius = 0.0;  ///< of a capsule; a box has this depth and the next half width
  double half_width = 0.0;
};

/// Joint to the parent: a hinge from 0 to `swing` if `hinge` is set; else a cone.
struct Hold {
  Part parent = Part::Pelvis;
  double height = 0.0;  ///< share of height, of the joint
  double hinge = 0.0;   ///< 1: bends backwards; -1: forwards; 0: a ball joint
  double swing = 0.0;   ///< rad
  double twist = 0.0;   ///< rad, either way
};

struct Piece {
  Limb limb;
  Hold hold;
};

/// m/s and rad/s: slower limbs count as at rest. Limbs on each other slide on for long at a few
/// millimetres a second; with the solver's thresholds none of twelve heaps of nine sleeps.
constexpr double kRestSpeed = 0.03;
constexpr double kRestSpin = 0.3;

constexpr double kHip = 0.530, kKnee = 0.285, kShoulder = 0.818, kElbow = 0.632;

constexpr Piece kUpperArm{{0.028, 0.155, kShoulder, kElbow, 0.025},
                          {Part::Chest, kShoulder, 0.0, 2.0, 1.2}};
constexpr Piece kThigh{{0.100, 0.0955, kHip, kKnee, 0.040}, {Part::Pelvis, kHip, 0.0, 1.4, 0.5}};
constexpr Limb kForearm{0.022, 0.155, kElbow, 0.378, 0.020};
constexpr Limb kShin{0.061, 0.0955, kKnee, 0.0, 0.030};

constexpr std::array<Piece, Ragdoll::kParts> kPieces{{
    {{0.142, 0.0, 0.630, 0.490, 0.060, 0.0955}, {}},
    {{0.355, 0.0, 0.820, 0.630, 0.060, 0.1295}, {Part::Pelvis, 0.630, 0.0, 0.5, 0.5}},
    {{0.081, 0.0, 1.000, 0.820, 0.050}, {Part::Chest, 0.820, 0.0, 0.6, 1.0}},
    kUpperArm,
    {kForearm, {Part::LeftUpperArm, kElbow, -1.0, 2.5, 0.0}},
    kUpperArm,
    {kForearm, {Part::RightUpperArm, kElbow, -1.0, 2.5, 0.0}},
    kThigh,
    {kShin, {Part::LeftThigh, kKnee, 1.0, 2.4, 0.0}},
    kThigh,
    {kShin, {Part::RightThigh, kKnee, 1.0, 2.4, 0.0}},
}};

bool is_right(std::size_t part) {
  return part == Part::RightUpperArm || part == Part::RightForearm || part == Part::RightThigh ||
         part == Part::RightShin;
}

void check(const RagdollDef& def) {
  constexpr std::string_view kKind = "RagdollDef";
  using pbd::detail::require;
  require(def.height > 0.0 && std::isfinite(def.height), kKind, "height", def.height,
          "finite and > 0");
  require(def.mass > 0.0 && std::isfinite(def.mass), kKind, "mass", def.mass, "finite and > 0");
  require(def.damping >= 0.0 && std::isfinite(def.damping), kKind, "damping", def.damping,
          "finite and >= 0");
}

collision::Shape shape_of(const Limb& limb, double height) {
  const double half = 0.5 * height * (limb.top - limb.bottom);
  if (limb.half_width > 0.0) return Box{height * limb.radius, height * limb.half_width, half};
  return Capsule{height * limb.radius, half - height * limb.radius};
}

pbd::SixDofJointDef joint_of(const Scene& scene, const RagdollDef& def, const Hold& hold,
                             BodyId parent, BodyId child, double side) {
  const Vec3 at = def.pose.to_world(def.height * Vec3(0.0, side, hold.height));
  const Quat& turn = def.pose.orientation;
  if (hold.hinge != 0.0) {
    pbd::HingeJointDef hinge =
        pbd::hinge_joint_at(scene.world(), parent, child, at, turn * (hold.hinge * Vec3::UnitY()));
    hinge.axis = {.freedom = pbd::Freedom::Limited,
                  .lower = 0.0,
                  .upper = hold.swing,
                  .spring = {.damping = def.damping}};
    return hinge;
  }
  pbd::BallJointDef ball =
      pbd::ball_joint_at(scene.world(), parent, child, at, turn * Vec3::UnitZ());
  ball.cone = hold.swing;
  ball.limit_twist = true;
  ball.lower_twist = -hold.twist;
  ball.upper_twist = hold.twist;
  pbd::SixDofJointDef joint = ball;
  for (pbd::JointAxis& axis : joint.angular) axis.spring = {.damping = def.damping};
  return joint;
}

}  // namespace

Ragdoll::Ragdoll(Scene& scene, const RagdollDef& def) {
  check(def);
  collision::Filter filter = def.filter;
  if (filter.group == 0) filter.group = scene.new_group();
  std::vector<BodyId> parts;
  detail::add_whole(scene, parts, [&] {
    for (std::size_t part = 0; part < kParts; ++part) {
      const auto& [limb, hold] = kPieces[part];
      const double side = is_right(part) ? -limb.side : limb.side;
      const Vec3 middle = def.height * Vec3(0.0, side, 0.5 * (limb.top + limb.bottom));
      bodies_[part] = scene.add(shape_of(limb, def.height),
                                {.mass = limb.mass * def.mass,
                                 .pose = {def.pose.to_world(middle), def.pose.orientation},
                                 .material = def.material,
                                 .filter = filter,
                                 .sleep_speed = kRestSpeed,
                                 .sleep_spin = kRestSpin,
                                 .user_data = def.user_data});
      parts.push_back(bodies_[part]);
      if (part == Part::Pelvis) continue;
      joints_[part] =
          scene.add_joint(joint_of(scene, def, hold, bodies_[hold.parent], bodies_[part], side));
    }
  });
}

}  // namespace tandem
