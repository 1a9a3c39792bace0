// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "values.h"

namespace tandem::python {

/// For all functions that make scenes. @throws as require_known() and take() do
SceneOptions options_of(const py::kwargs& given, const char* function);

}  // namespace tandem::python
