// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "copies/copy.h"

#include <utility>

namespace tandem::peers_bench {

CopyBuilder::CopyBuilder() {
  copy_.world = std::make_unique<pbd::World>();
  copy_.contacts = std::make_unique<collision::CollisionScene>();
}

pbd::BodyId CopyBuilder::box(const BoxDef& def) {
  const collision::Box shape{def.half};
  const double density = def.mass / (8.0 * def.half.prod());
  const auto properties = collision::mass_properties(shape, density);
  const pbd::BodyId body = copy_.world->add_body({.pose = def.pose,
                                                  .twist = def.twist,
                                                  .mass = properties.mass,
                                                  .inertia = properties.inertia,
                                                  .can_sleep = false});
  copy_.bodies.push_back(body);
  if (def.collides) {
    copy_.boxes.push_back({body, def.half});
    copy_.contacts->add(*copy_.world, {.body = body, .shape = shape});
  }
  return body;
}

void CopyBuilder::wall(const pbd::Vec3& centre, const pbd::Vec3& half) {
  pbd::BodyDef def;
  def.type = pbd::BodyType::Static;
  def.pose.position = centre;
  const pbd::BodyId body = copy_.world->add_body(def);
  copy_.walls.push_back({body, half});
  copy_.contacts->add(*copy_.world, {.body = body, .shape = collision::Box{half}});
}

pbd::BodyId CopyBuilder::hook() { return copy_.world->add_body({.type = pbd::BodyType::Static}); }

void CopyBuilder::joint(const pbd::SixDofJointDef& def) {
  if (copy_.joints == nullptr) copy_.joints = &copy_.world->add_block<pbd::JointBlock>();
  copy_.joint_ids.push_back(copy_.joints->add(*copy_.world, def));
}

Copy CopyBuilder::done() {
  if (!copy_.boxes.empty()) copy_.world->set_contact_source(copy_.contacts.get());
  return std::move(copy_);
}

}  // namespace tandem::peers_bench
