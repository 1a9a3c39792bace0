// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The parts of the module. Shapes come first: the others have them in their signatures.
#pragma once

#include "core.h"

namespace tandem::python {

using SceneClass = py::class_<Core, std::shared_ptr<Core>>;

void bind_shapes(py::module_& m);
void bind_bodies(py::module_& m);
SceneClass bind_scene(py::module_& m);
void bind_joints(py::module_& m, SceneClass& scene);
void bind_queries(py::module_& m, SceneClass& scene);
void bind_contacts(py::module_& m, SceneClass& scene);
void bind_files(SceneClass& scene);
void bind_characters(py::module_& m);
void bind_cars(py::module_& m);
void bind_ropes(py::module_& m);
void bind_cloth(py::module_& m);
void bind_ragdolls(py::module_& m);
void bind_shown(SceneClass& scene);
void bind_batch(py::module_& m);
void bind_networks(py::module_& m);
void bind_sessions(py::module_& m);

}  // namespace tandem::python
