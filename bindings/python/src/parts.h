// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Common parts of characters, cars, ropes, cloth and ragdolls: each is made of bodies of a scene,
// which it keeps alive.
#pragma once

#include <span>
#include <string>

#include "body.h"
#include "keywords.h"
#include "tandem/pbd/cloth_block.h"

namespace tandem::python {

/// Attaches a particle of a rope or of a cloth to a body.
struct Attachment {
  CorePtr core;
  pbd::ClothRowId id;
};

/// category, mask and group
void take_filter(const py::kwargs& given, collision::Filter& filter);
/// friction and restitution
void take_material(const py::kwargs& given, collision::Material& material);

std::vector<Body> bodies_of(const CorePtr& core, std::span<const BodyId> ids);
/// Centres of mass: n x 3, a copy. @throws if one has been removed
py::array_t<double> points_of(Core& core, std::span<const BodyId> ids);
bool all_there(Core& core, std::span<const BodyId> ids);
/// @throws std::invalid_argument if one has been removed
void require_there(Core& core, std::span<const BodyId> ids, const char* name);
void remove_all(Core& core, std::span<const BodyId> ids);

/// From 0 to count - 1; negative ones count from the end, as in Python's sequences.
/// @throws std::invalid_argument naming the field
int place_of(int index, std::size_t count, const char* field);

/// @tparam Part  has the scene's `core`, and ids() of all its bodies
template <class Part>
void bind_life(py::class_<Part>& c) {
  c.def_property_readonly(
      "alive", [](const Part& p) { return all_there(*p.core, p.ids()); },
      "none of its bodies was removed");
  c.def(
      "remove", [](const Part& p) { remove_all(*p.core, p.ids()); },
      "Remove its bodies from the scene, with their joints.");
}

}  // namespace tandem::python
