// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Keyword arguments from Python. Absent ones keep the definition's defaults, so that there is only
// one list of defaults.
#pragma once

#include <pybind11/stl.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "tandem/pbd/validate.h"
#include "values.h"

namespace tandem::python {

/// @throws py::type_error like Python's own functions
void require_known(const py::kwargs& given, const char* function,
                   std::initializer_list<std::string_view> known);

template <class T>
void take(const py::kwargs& given, const char* name, T& field) {
  if (!given.contains(name)) return;
  const py::handle value = given[name];
  try {
    field = value.cast<T>();
  } catch (const py::cast_error&) {
    throw py::type_error(std::string(name) +
                         " is of the wrong type: " + std::string(py::repr(value)));
  }
}

inline void take(const py::kwargs& given, const char* name, Vec3& field) {
  if (given.contains(name)) field = vec3(given[name], name);
}

inline void take(const py::kwargs& given, const char* name, Quat& field) {
  if (given.contains(name)) field = quat(given[name], name);
}

/// One of these words, as an index. @throws std::invalid_argument naming them
template <class Enum>
void take_word(const py::kwargs& given, const char* name,
               std::initializer_list<std::string_view> words, Enum& field) {
  if (!given.contains(name)) return;
  const std::string text = py::str(given[name]);
  int place = 0;
  std::string rule = "one of";
  for (const std::string_view word : words) {
    if (text == word) {
      field = static_cast<Enum>(place);
      return;
    }
    rule += (place++ == 0 ? " '" : ", '") + std::string(word) + "'";
  }
  pbd::detail::refuse(name, rule, "'" + text + "'");
}

}  // namespace tandem::python
