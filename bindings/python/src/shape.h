// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "values.h"

namespace tandem::python {

/// Base of all shapes in Python.
struct ShapeValue {
  collision::Shape shape;
};

/// One shape of several on a body.
struct PartValue {
  collision::CompoundPart part;
};

/// The shape as what it is in Python: a Sphere, a Box ...
py::object object_of(const collision::Shape& shape);

}  // namespace tandem::python
