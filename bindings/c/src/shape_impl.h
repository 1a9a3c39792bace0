// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/c/tandem.h"
#include "tandem/collision/shape.h"

namespace tandem::c {

/// @throws std::invalid_argument naming the fault
collision::Shape shape_of(const tandem_shape& shape);

}  // namespace tandem::c
