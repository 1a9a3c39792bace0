// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "parts.h"

namespace tandem::python {

void take_filter(const py::kwargs& given, collision::Filter& filter) {
  take(given, "category", filter.category);
  take(given, "mask", filter.mask);
  take(given, "group", filter.group);
}

void take_material(const py::kwargs& given, collision::Material& material) {
  take(given, "friction", material.friction);
  take(given, "restitution", material.restitution);
}

std::vector<Body> bodies_of(const CorePtr& core, std::span<const BodyId> ids) {
  std::vector<Body> result;
  for (const BodyId id : ids) result.push_back({core, id});
  return result;
}

py::array_t<double> points_of(Core& core, std::span<const BodyId> ids) {
  py::array_t<double> result(
      std::vector<py::ssize_t>{static_cast<py::ssize_t>(ids.size()), py::ssize_t{3}});
  double* to = result.mutable_data();
  const pbd::World& world = core.scene().world();
  for (const BodyId id : ids) {
    const Vec3& at = world.pose(id).position;
    for (int i = 0; i < 3; ++i) *to++ = at[i];
  }
  return result;
}

bool all_there(Core& core, std::span<const BodyId> ids) {
  const pbd::World& world = core.scene().world();
  for (const BodyId id : ids) {
    if (!world.contains(id)) return false;
  }
  return true;
}

void require_there(Core& core, std::span<const BodyId> ids, const char* name) {
  if (!all_there(core, ids)) pbd::detail::refuse(name, "one whose bodies are all in the scene");
}

void remove_all(Core& core, std::span<const BodyId> ids) {
  Access scene(core);
  // The last one first, so that the next ones get their rows in the same order.
  for (std::size_t i = ids.size(); i-- > 0;) {
    if (scene->world().contains(ids[i])) scene->remove(ids[i]);
  }
}

int place_of(int index, std::size_t count, const char* field) {
  const int size = static_cast<int>(count);
  if (index < -size || index >= size) {
    pbd::detail::refuse(field, "from " + std::to_string(-size) + " to " + std::to_string(size - 1),
                        std::to_string(index));
  }
  return index < 0 ? index + size : index;
}

}  // namespace tandem::python
