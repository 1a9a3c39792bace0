// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>

#include "values.h"

namespace tandem::python {

/// All shapes of the bodies in these rows, by row: tuples of row, shape, position (m) and
/// orientation in the body's shape frame, and whether it is a sensor.
py::list parts_of(const tandem::Scene& scene, std::span<const std::uint32_t> rows);

}  // namespace tandem::python
