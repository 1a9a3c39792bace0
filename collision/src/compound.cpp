// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/compound.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::collision {

using pbd::Mat3;
using pbd::Vec3;

namespace {

void check_local(const pbd::Pose& local, const std::string& part) {
  const std::string field = part + ".local.";
  pbd::detail::require_finite(local.position, "mass_properties", field + "position");
  pbd::detail::require_unit(local.orientation, "mass_properties", field + "orientation");
}

}  // namespace

MassProperties mass_properties(std::span<const CompoundPart> parts) {
  if (parts.empty()) pbd::detail::refuse("mass_properties: parts", "at least one", "none");
  std::vector<MassProperties> placed;
  MassProperties all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    MassProperties p;
    check_local(parts[i].local, "parts[" + std::to_string(i) + "]");
    try {
      p = mass_properties(parts[i].shape, parts[i].density);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("parts[" + std::to_string(i) + "]: " + error.what());
    }
    const Mat3 turn = parts[i].local.orientation.normalized().toRotationMatrix();
    p.com = parts[i].local.position + turn * p.com;
    p.inertia = turn * p.inertia * turn.transpose();
    all.mass += p.mass;
    all.com += p.mass * p.com;
    placed.push_back(p);
  }
  // Each part is valid, but their sum may not be.
  if (!(all.mass > 0.0) || !std::isfinite(all.mass)) {
    pbd::detail::refuse("mass_properties: mass of all parts", "finite and > 0", all.mass);
  }
  all.com /= all.mass;
  if (!all.com.allFinite()) {
    pbd::detail::refuse("mass_properties: centre of mass of all parts", "finite", all.com.sum());
  }
  for (const MassProperties& p : placed) {
    const Vec3 d = p.com - all.com;
    all.inertia += p.inertia + p.mass * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  }
  if (!all.inertia.allFinite()) {
    pbd::detail::refuse("mass_properties: inertia of all parts", "finite", all.inertia.trace());
  }
  return all;
}

std::vector<ColliderId> add_compound(CollisionScene& scene, const pbd::World& world,
                                     const ColliderDef& def, std::span<const CompoundPart> parts) {
  std::vector<ColliderId> ids;
  ColliderDef part = def;
  try {
    for (const CompoundPart& p : parts) {
      part.shape = p.shape;
      part.local.position = def.local.to_world(p.local.position);
      part.local.orientation = def.local.orientation * p.local.orientation;
      ids.push_back(scene.add(world, part));
    }
  } catch (...) {
    for (const ColliderId id : ids) scene.remove(id);
    throw;
  }
  return ids;
}

}  // namespace tandem::collision
