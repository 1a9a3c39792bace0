// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/ragdoll.h"

#include "bind.h"
#include "joint.h"
#include "parts.h"

namespace tandem::python {
namespace {

/// In the order of Ragdoll::Part.
constexpr std::array<const char*, tandem::Ragdoll::kParts> kPartNames = {
    "pelvis",        "chest",      "head",      "left_upper_arm", "left_forearm", "right_upper_arm",
    "right_forearm", "left_thigh", "left_shin", "right_thigh",    "right_shin"};

struct RagdollPart {
  CorePtr core;
  tandem::Ragdoll ragdoll;

  const std::array<BodyId, tandem::Ragdoll::kParts>& ids() const { return ragdoll.bodies(); }
};

RagdollDef ragdoll_def(const py::kwargs& given) {
  require_known(given, "Ragdoll",
                {"position", "orientation", "height", "mass", "damping", "friction", "restitution",
                 "category", "mask", "group"});
  RagdollDef def;
  take(given, "position", def.pose.position);
  take(given, "orientation", def.pose.orientation);
  take(given, "height", def.height);
  take(given, "mass", def.mass);
  take(given, "damping", def.damping);
  take_material(given, def.material);
  take_filter(given, def.filter);
  return def;
}

std::unique_ptr<RagdollPart> make_ragdoll(Core& core, const py::kwargs& given) {
  const RagdollDef def = ragdoll_def(given);
  Access scene(core);
  core.require_room_for(tandem::Ragdoll::kParts);
  return std::unique_ptr<RagdollPart>(
      new RagdollPart{core.shared_from_this(), tandem::Ragdoll(*scene, def)});
}

py::dict limbs(const RagdollPart& p) {
  py::dict result;
  for (std::size_t i = 0; i < kPartNames.size(); ++i) {
    result[kPartNames[i]] = Body{p.core, p.ids()[i]};
  }
  return result;
}

py::dict limb_joints(const RagdollPart& p) {
  py::dict result;
  for (std::size_t i = 1; i < kPartNames.size(); ++i) {  // the pelvis is the root
    result[kPartNames[i]] = Joint{p.core, p.ragdoll.joint(static_cast<tandem::Ragdoll::Part>(i))};
  }
  return result;
}

}  // namespace

void bind_ragdolls(py::module_& m) {
  py::class_<RagdollPart> c(
      m, "Ragdoll", R"(Somebody who has fainted: eleven bodies on ten joints with people's limits.

Keywords, all optional: position, orientation (of the frame between the feet: x forward, y left, z up),
height (m), mass (kg, of all of it), damping (N m s/rad, of each joint), friction, restitution, category,
mask, group. As in RagdollDef.

>>> import tandem
>>> scene = tandem.Scene()
>>> doll = tandem.Ragdoll(scene, mass=80.0)
>>> round(sum(body.mass for body in doll.bodies.values()), 6)
80.0
>>> list(doll.bodies)[:3], len(doll.joints)
(['pelvis', 'chest', 'head'], 10)
)");
  c.def(py::init(&make_ragdoll), py::arg("scene"));
  c.def_property_readonly("bodies", &limbs,
                          "by name: pelvis, chest, head, left_upper_arm, left_forearm, "
                          "right_upper_arm, right_forearm, left_thigh, left_shin, right_thigh, "
                          "right_shin");
  c.def_property_readonly(
      "joints", &limb_joints,
      "what holds each of them, by the same names: spine, neck, shoulder, elbow, hip, knee; of the "
      "pelvis none");
  bind_life(c);
}

}  // namespace tandem::python
