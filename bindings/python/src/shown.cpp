// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Data for tandem.view(): all bodies in one call, which is made for every frame.
#include "shown.h"

#include <algorithm>
#include <vector>

#include "bind.h"
#include "body.h"
#include "shape.h"

namespace tandem::python {
namespace {

using Rows = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

/// The number of restores; then for each body, by row: index and generation; type (0 static, 1
/// kinematic, 2 dynamic) and whether it is awake; position (m) and orientation (x, y, z, w) of its
/// shape's frame.
py::tuple shown(Core& core) {
  const Access scene(core);
  const pbd::World& world = core.scene().world();
  const auto count = static_cast<py::ssize_t>(world.body_count());
  py::array_t<std::uint32_t> ids({count, py::ssize_t{2}});
  py::array_t<std::uint8_t> kinds({count, py::ssize_t{2}});
  py::array_t<double> poses({count, py::ssize_t{7}});
  auto id_rows = ids.mutable_unchecked<2>();
  auto kind_rows = kinds.mutable_unchecked<2>();
  auto pose_rows = poses.mutable_unchecked<2>();
  py::ssize_t row = 0;
  for (std::uint32_t slot = 0; slot < world.slot_count(); ++slot) {
    const BodyId id = world.body_at(slot);
    if (!id.valid()) continue;
    id_rows(row, 0) = id.index;
    id_rows(row, 1) = id.generation;
    kind_rows(row, 0) = static_cast<std::uint8_t>(world.props(id).type);
    kind_rows(row, 1) = world.awake(id) ? 1 : 0;
    const Pose pose = core.scene().pose(id);
    for (py::ssize_t i = 0; i < 3; ++i) pose_rows(row, i) = pose.position[i];
    for (py::ssize_t i = 0; i < 4; ++i) pose_rows(row, 3 + i) = pose.orientation.coeffs()[i];
    ++row;
  }
  return py::make_tuple(core.restores, ids, kinds, poses);
}

}  // namespace

py::list parts_of(const tandem::Scene& scene, std::span<const std::uint32_t> rows) {
  std::vector<bool> wanted(scene.world().slot_count());
  for (const std::uint32_t row : rows) {
    if (row < wanted.size()) wanted[row] = true;
  }
  struct Part {
    std::uint32_t row;
    std::uint32_t slot;
  };
  std::vector<Part> found;
  const collision::CollisionScene& shapes = scene.shapes();
  for (std::uint32_t slot = 0; slot < shapes.slot_count(); ++slot) {
    const collision::ColliderId id = shapes.collider_at(slot);
    if (!shapes.contains(id)) continue;
    const std::uint32_t row = shapes.collider(id).body.index;
    if (row < wanted.size() && wanted[row]) found.push_back({row, slot});
  }
  std::ranges::stable_sort(found, {}, &Part::row);
  py::list parts;
  for (const Part& part : found) {
    const collision::ColliderDef& def = shapes.collider(shapes.collider_at(part.slot));
    // Colliders are relative to the centre of mass.
    const Vec3 position = def.local.position - scene.world().props(def.body).origin;
    parts.append(py::make_tuple(part.row, object_of(def.shape), array_of(position),
                                array_of(def.local.orientation), def.sensor));
  }
  return parts;
}

void bind_shown(SceneClass& scene) {
  scene.def("_shown", &shown,
            "For tandem.view(): number of restores; ids, kinds and poses of all bodies, by row.");
  scene.def(
      "_parts",
      [](Core& core, const Rows& rows) {
        return parts_of(core.scene(), {rows.data(), static_cast<std::size_t>(rows.size())});
      },
      py::arg("rows"), "For tandem.view(): all shapes of the bodies in these rows.");
}

}  // namespace tandem::python
