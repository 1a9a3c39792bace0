// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "core.h"

namespace tandem::python {

/// A body of a scene, which it keeps alive.
struct Body {
  CorePtr core;
  BodyId id;

  friend bool operator==(const Body&, const Body&) = default;
};

/// The body in `core`, or the world's invalid id if there is none.
/// @throws std::invalid_argument naming the field, if the body is of another scene
BodyId id_in(const Core& core, const std::optional<Body>& body, const char* field);

}  // namespace tandem::python
