// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "values.h"

namespace tandem::python {

/// Base of all shapes in Python.
struct ShapeValue {
  collision::Shape shape;
};

/// One of several shapes of a body.
struct PartValue {
  collision::CompoundPart part;
};

/// The shape as its Python type: a Sphere, a Box ...
py::object object_of(const collision::Shape& shape);

}  // namespace tandem::python
