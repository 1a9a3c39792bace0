// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "values.h"

#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// @throws std::invalid_argument if the value is not `count` numbers
Numbers numbers(const py::handle& value, std::string_view field, py::ssize_t count,
                std::string_view rule) {
  Numbers array = Numbers::ensure(value);
  if (!array) PyErr_Clear();
  if (!array || array.ndim() != 1 || array.size() != count) {
    pbd::detail::refuse(field, rule, std::string(py::repr(value)));
  }
  return array;
}

}  // namespace

Vec3 vec3(const py::handle& value, std::string_view field) {
  const Numbers n = numbers(value, field, 3, "three numbers");
  return {n.at(0), n.at(1), n.at(2)};
}

Quat quat(const py::handle& value, std::string_view field) {
  const Numbers n = numbers(value, field, 4, "four numbers (x, y, z, w)");
  return {n.at(3), n.at(0), n.at(1), n.at(2)};
}

std::vector<Vec3> points(const py::handle& value, std::string_view field) {
  const Numbers array = Numbers::ensure(value);
  if (!array) PyErr_Clear();
  if (!array || array.ndim() != 2 || array.shape(1) != 3) {
    pbd::detail::refuse(field, "an array of n x 3 numbers", std::string(py::repr(value)));
  }
  std::vector<Vec3> result;
  result.reserve(static_cast<std::size_t>(array.shape(0)));
  for (py::ssize_t i = 0; i < array.shape(0); ++i) {
    result.emplace_back(array.at(i, 0), array.at(i, 1), array.at(i, 2));
  }
  return result;
}

py::array_t<double> array_of(std::span<const double> values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}
py::array_t<double> array_of(const Vec3& value) { return py::array_t<double>(3, value.data()); }
py::array_t<double> array_of(const Quat& value) {
  return py::array_t<double>(4, value.coeffs().data());
}

}  // namespace tandem::python
