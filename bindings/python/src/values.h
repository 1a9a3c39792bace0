// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Numbers from Python and back: errors name field, value and rule.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tandem/scene.h"

namespace tandem::python {

namespace py = pybind11;

/// Three numbers: a tuple, list or array. @throws std::invalid_argument naming the field
Vec3 vec3(const py::handle& value, std::string_view field);
/// A unit quaternion in the order x, y, z, w. @throws as vec3
Quat quat(const py::handle& value, std::string_view field);
/// Rows of three numbers. @throws as vec3
std::vector<Vec3> points(const py::handle& value, std::string_view field);

py::array_t<double> array_of(const Vec3& value);
/// x, y, z, w
py::array_t<double> array_of(const Quat& value);
py::array_t<double> array_of(std::span<const double> values);

}  // namespace tandem::python
